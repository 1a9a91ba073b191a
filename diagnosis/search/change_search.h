// SPDX-License-Identifier: BSD-3-Clause
// When did something begin or end (factors/effects/change.h)? Every span of windows is tried in one
// pass over the recordings, then the times are found to the sample.
//
// The pass: condensed windows (calibration/scan/scan.h) carry the columns of each change as if it
// lasted throughout. What the windows of a span say of it, sums of their scores and information
// over the span, and what all windows say of everything else, give the score statistic of a change
// that begins with the span and ends with it. Sums over spans are differences of cumulative ones,
// so a span costs a few small products. Windows are cut from each other there: that loses some
// power, so the best spans of each kind go through the scan once more, exactly (scan_options.h).
#pragma once

#include <array>
#include <functional>

#include "calibration/scan/scan.h"
#include "factors/effects/change.h"

namespace magimu {

// As so many independent tests count all spans of windows, neighbours being much the same.
double lasting_spans(int windows);
double ended_spans(int windows);

struct LikelyChange {
  std::string name = {};
  ChangeForm form = ChangeForm::kOffset;
  ChangeSpan span = {};
  double statistic = 0.0;
  int dof = 0;
  double tried = 1.0;  // as so many independent tests count all of its kind

  // Of its chi-square tail, corrected for what was tried.
  double log10_p() const;
};

// Of each of these names the best, where there is any: one that lasts, or one that ends.
std::vector<LikelyChange> likely_changes(const std::vector<const Recording*>& recordings,
                                         const Stage& stage, const std::vector<std::string>& names);

// Windows of the search for changes of a channel, s.
double change_window_s(const std::vector<NodePlan>& plans, Channel channel, MotionModel motion);

struct ChangeTimes {
  ChangeSpan span = {};
  double sigma_s = 0.0;  // of the less certain time
  // The integral of each one's likelihood over its maximum: all that is as good as the best.
  std::array<double, 2> width_s = {0.0, 0.0};
};

// The times of a change that is in the model as its last effect (perhaps with another prior), to
// the sample: those that make the
// readings the most probable, everything else adapting. (Residuals tell less: a stretch of a few
// seconds shows few directions of the field, and a fit with a wrong time bends to it.)
// refit: the model with such times.
ChangeTimes refined_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                          const ChangeEffect& change, const ChangeTimes& now,
                          const std::function<Stage(const ChangeTimes&)>& refit);

// The times by what a fit with each costs, within some windows of those now: where a large change
// at a wrong time has bent the fit, so that what that leaves does not show the right one.
ChangeTimes times_by_refits(const std::vector<const Recording*>& recordings,
                            const ChangeEffect& change, const ChangeTimes& now,
                            const std::function<Stage(const ChangeTimes&)>& refit);

// In nats: any moment was as likely before, those that are as good as the best are now.
double cost_of_times(const ChangeTimes& times, const std::vector<const Recording*>& recordings);

}  // namespace magimu
