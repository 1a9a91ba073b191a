// SPDX-License-Identifier: BSD-3-Clause
// When did something begin or end (factors/effects/change.h)? Every span of windows is tried in one
// pass over the recordings, then the times are found to the sample.
//
// The pass: condensed windows (calibration/scan/scan.h) carry the columns of each change as if it
// lasted throughout. The scores and the information of the windows of a span, summed, and those of
// all windows about everything else, give the score statistic of a change that begins and ends with
// the span. Sums over spans are differences of cumulative ones, so a span costs a few small
// products. Windows are cut from each other there: that loses some power, so the best spans of each
// kind go through the scan once more, exactly (scan_options.h).
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>

#include "calibration/scan/scan.h"
#include "factors/effects/change.h"

namespace magimu {

// The search over all spans of so many windows counts as this number of independent tests (fewer
// than there are spans: neighbouring spans are nearly the same test).
double lasting_spans(int windows);
double ended_spans(int windows);

struct LikelyChange {
  std::string name = {};
  ChangeForm form = ChangeForm::kOffset;
  ChangeSpan span = {};
  double statistic = 0.0;
  int dof = 0;
  double tried = 1.0;  // number of independent tests that the search for its kind counts as

  // Of its chi-square tail, corrected for what was tried.
  double log10_p() const;
  std::shared_ptr<const Effect> effect() const;
};

// The best change of each of these names, if there is any: one that lasts or one that ends.
std::vector<LikelyChange> likely_changes(const std::vector<const Recording*>& recordings,
                                         const Stage& stage, const std::vector<std::string>& names);

// The same of the sensors' biases: what was attached or taken off, or began to warm up.
std::vector<LikelyChange> changes_of_bias(const std::vector<const Recording*>& recordings,
                                          const Stage& stage);

// Does the sensor turn inside, or outside, of this span, leaving so many seconds about its ends
// aside? If it does not outside, a change of its gains in it is nothing but gains that are the same
// throughout: the first rest tells of one attitude only.
bool turns(const Stage& stage, const ChangeSpan& span, bool inside, double margin_s = 0.0);

// Windows of the search for changes of a channel, s.
double change_window_s(const std::vector<NodePlan>& plans, Sensor channel, MotionModel motion);

struct ChangeTimes {
  ChangeSpan span = {};
  std::array<double, 2> sigma_s = {0.0, 0.0};
  // The integral of each time's likelihood over its maximum: the width of what is about as likely.
  std::array<double, 2> width_s = {0.0, 0.0};
};

// The times, to the sample, of a change that is in the model as its last effect (perhaps with
// another prior): those that make the readings the most probable when everything else adapts.
// (Residuals tell less: a stretch of a few seconds shows few directions of the field, and a fit
// with a wrong time adapts to it.) refit: the model with such times.
ChangeTimes refined_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                          const ChangeEffect& change, const ChangeTimes& now,
                          const std::function<Stage(const ChangeTimes&)>& refit);

// Does a change that is in the model as its last effect, and lasts, rather end (or one that was
// there from the start rather begin)? The span with the end that makes the readings the most
// probable when everything else adapts, by one step; nothing where no end is worth the choice among
// so many. The windows of the first search are too long to tell: an end near to the recording's
// adds little.
std::optional<ChangeSpan> with_both_ends(const std::vector<const Recording*>& recordings,
                                         const Stage& stage, const ChangeEffect& change,
                                         const ChangeSpan& now);

// The times by the cost of a fit with each, within some windows of those now: for a large change
// that at a wrong time has distorted the fit so much that its residuals do not show the right one.
ChangeTimes times_by_refits(const std::vector<const Recording*>& recordings,
                            const ChangeEffect& change, const ChangeTimes& now,
                            const std::function<Stage(const ChangeTimes&)>& refit);

// What the choice of times costs, in nats: each time's log of the length of all recordings over the
// width of what is about as likely.
double cost_of_times(const ChangeTimes& times, const std::vector<const Recording*>& recordings);

}  // namespace magimu
