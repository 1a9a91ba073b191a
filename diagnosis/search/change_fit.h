// SPDX-License-Identifier: BSD-3-Clause
// A change in the model, as its last effect: when it began, whether it ended, and in which form
// (factors/effects/change.h) it explains most. The search over windows (change_search.h) gives a
// start; here each step is a fit, kept where it explains more.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "calibration/pipeline.h"
#include "calibration/scan/change_search.h"

namespace magimu {

class ChangeFit {
 public:
  // with: the change in the model, at span. from: a fit without it or with it, where fits with
  // other times begin with the parameters `start`. cost_without: of a fit without it, infinite
  // where the change is known to be there. All must outlive this, with excepted.
  ChangeFit(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
            const Stage& from, const Stage& with, const ChangeSpan& span, VectorXd start,
            double cost_without);

  const Stage& stage() const { return now_.stage; }
  const ChangeTimes& times() const { return now_.times; }
  const ChangeEffect& change() const { return *as_change(*now_.spec.effects.back()); }
  VectorXd parameters() const { return parameters_of(now_.stage); }

  // May throw NumericalError, as may move_to and refine_by_refits.
  void refine_times();
  // By the cost of a fit with each of many times about `near`.
  void refine_by_refits(const ChangeSpan& near);
  // One end only, where the change is not less likely from the start on, or to the end: a time
  // costs what the choice among all times does.
  void take_one_end();
  // An end (or a beginning), where the change is more likely to have both.
  void take_both_ends();
  // The form that explains most at these times, and the times once more with it.
  void take_better_form();
  // The bias alone, where at these times nothing else need have changed. A bias that comes and goes
  // is not looked for by itself: it is found as a change of gains with a bias.
  void take_bias_alone();
  // start: of the parameters, where they turn with the times.
  void move_to(const ChangeSpan& span, const VectorXd& start);

 private:
  struct State {
    Stage stage;
    ModelSpec spec;
    ChangeTimes times;
    VectorXd start;  // of fits with other times
    std::optional<std::pair<ChangeSpan, Stage>> last = {};
  };
  VectorXd parameters_of(const Stage& stage) const;
  Stage fit(const ChangeTimes& times);
  Stage fit_as(const std::string& name, ChangeForm form);
  bool may_be_richer() const;
  double cost_as(ChangeForm form);
  // The times that `search` finds with fits of this change; the fit with them is taken.
  using Fits = std::function<Stage(const ChangeTimes&)>;
  void take_times(const std::function<ChangeTimes(const ChangeEffect&, const Fits&)>& search);

  const std::vector<const Recording*>& recordings_;
  const Pipeline& pipeline_;
  const Stage& from_;
  double cost_without_;
  State now_;
};

// Are parameters of an effect far beyond the prior, which is what parts, or fields, differ by?
bool is_beyond_parts(const Effect& effect, const VectorXd& theta);
// When both begin or end, about; of the first.
std::optional<Moment> moment_in_common(const ChangeSpan& a, const ChangeSpan& b);
// Times from which a fit finds the way to others.
bool are_near(const ChangeSpan& a, const ChangeSpan& b);

}  // namespace magimu
