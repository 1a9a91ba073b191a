// SPDX-License-Identifier: BSD-3-Clause
// When did the magnetometer's bias change: every span of windows tried in one scan, then the times
// found to the sample.
#pragma once

#include <memory>

#include "calibration/scan.h"
#include "recording/recording.h"

namespace magimu {

constexpr double kChangeWindow = 5.0;  // s, at the least
constexpr int kMaxChangeWindows = 24;

struct BiasChange {
  double t0 = 0.0, t1 = 0.0;  // s; infinite beyond the recording's ends
  Score score;
  double log10_p = 0.0;  // corrected for the number of spans tried
};

// scan: with bias_in_windows as its candidate number `candidate`.
BiasChange find_bias_change(const Scan& scan, std::size_t candidate, int windows, double begin_s,
                            double end_s);

// The time at which `residual` (of single samples, the change not subtracted) leaves zero for
// `step`, or returns: the best split within `within` seconds of `near`. rising: it is zero before.
double refine_time(const VectorSeries& residual, const Vector3& step, double near, double within,
                   bool rising);

}  // namespace magimu
