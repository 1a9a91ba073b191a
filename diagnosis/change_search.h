// SPDX-License-Identifier: BSD-3-Clause
// When did the magnetometer's bias change: every span of windows tried in one scan, then the times
// found to the sample.
#pragma once

#include <array>
#include <functional>

#include "calibration/scan.h"

namespace magimu {

// So many windows of some seconds.
int change_windows(const Recording& recording);

// One that lasts, or one that ends: as likely before.
inline constexpr double kChangeKinds = 2.0;
// As so many independent tests count all spans of windows, neighbours being much the same.
double lasting_spans(int windows);
double ended_spans(int windows);

struct BiasChange {
  double t0 = 0.0, t1 = 0.0;  // s; infinite beyond the recording's ends
  Score score;
  double log10_p = 0.0;  // corrected for the number of spans tried
};

// scan: with bias_in_windows of change_windows as its candidate number `candidate`.
BiasChange find_bias_change(const Scan& scan, std::size_t candidate, const Recording& recording);

struct ChangeTimes {
  double t0, t1;         // s; infinite ones stay
  double sigma_s = 0.0;  // to a twentieth of a second, of the less certain one
  // The integral of each one's likelihood over its maximum: all that is as good as the best.
  std::array<double, 2> width_s = {0.0, 0.0};
};

// The times of a change that is in the model as its last effect, to the sample. First, to half a
// second and then to a twentieth, those that make the readings the most probable, everything else
// adapting: a stretch of a few seconds shows few directions of the field, so that a fit with a
// wrong time bends to it and its residuals agree. Then by the residuals of a fit with these.
// refit: the model with such times.
ChangeTimes refined_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                          const ChangeTimes& now,
                          const std::function<Stage(const ChangeTimes&)>& refit);

// In nats: any moment was as likely before, those that are as good as the best are now.
double cost_of_times(const ChangeTimes& times, const Recording& recording);

}  // namespace magimu
