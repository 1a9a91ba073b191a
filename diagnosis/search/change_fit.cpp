// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/change_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "calibration/model/extension.h"
#include "calibration/scan/scan.h"
#include "diagnosis/search/option.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr int kOnceMore = 3;  // fits that have not converged

bool is_near(const Moment& x, const Moment& y) {
  constexpr double kNear = 0.5;  // s
  return x == y || (x.recording == y.recording && std::abs(x.t - y.t) < kNear);
}

}  // namespace

bool is_beyond_parts(const Effect& effect, const VectorXd& theta) {
  constexpr double kPriorSigmas = 5.0;
  for (int i = 0; i < effect.size(); ++i) {
    if (std::abs(theta[i]) >
        kPriorSigmas * effect.description().parameters[std::size_t(i)].prior_sigma) {
      return true;
    }
  }
  return false;
}

std::optional<Moment> moment_in_common(const ChangeSpan& a, const ChangeSpan& b) {
  for (const Moment& x : {a.begin, a.end}) {
    for (const Moment& y : {b.begin, b.end}) {
      if (x.finite() && is_near(x, y)) return x;
    }
  }
  return std::nullopt;
}

bool are_near(const ChangeSpan& a, const ChangeSpan& b) {
  return is_near(a.begin, b.begin) && is_near(a.end, b.end);
}

ChangeFit::ChangeFit(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                     const Stage& from, const Stage& with, const ChangeSpan& span, VectorXd start,
                     double cost_without)
    : recordings_(recordings),
      pipeline_(pipeline),
      from_(from),
      cost_without_(cost_without),
      now_{with, with.spec(), {.span = span}, std::move(start)} {}

VectorXd ChangeFit::parameters_of(const Stage& stage) const {
  return effect_parameters(stage.result().values, effect_keys(stage.spec().effects).back());
}

Stage ChangeFit::fit(const ChangeTimes& times) {
  const auto& last = now_.last;
  if (last && last->first.begin == times.span.begin && last->first.end == times.span.end) {
    return last->second;
  }
  const std::string name = change().name();
  const ChangeForm form = change().form();
  ModelSpec& spec = now_.spec;
  spec.effects.back() = make_change(name, form, times.span);
  // From the last fit where the times have hardly moved. A magnet at another time bends the
  // trajectory far, and the way back takes long.
  const bool near = last && last->second.result().converged() && are_near(last->first, times.span);
  Stage fitted =
      near ? pipeline_.refit_with_same_noise(last->second, spec, parameters_of(last->second))
           : pipeline_.refit_with_same_noise(from_, spec, now_.start);
  for (int again = 0; again < kOnceMore && !fitted.result().converged(); ++again) {
    fitted = pipeline_.refit_with_same_noise(fitted, spec, parameters_of(fitted));
  }
  // Gains of a few per cent bend nothing: where their fit finds no end, or one that no part has,
  // few samples tell of them. A sensor that fails may change by anything, but then hardly anything
  // else is wrong. A field that is stronger by half is no field of a place (a sensor whose readings
  // change their sign would be one that turns round).
  const bool of_field = is_field_change(*spec.effects.back());
  const bool fails = !of_field && fitted.result().cost_final < (1.0 - kMost) * cost_without_;
  if ((form != ChangeForm::kOffset || of_field) &&
      (!fitted.result().converged() ||
       (!fails && is_beyond_parts(*spec.effects.back(), parameters_of(fitted))))) {
    throw NumericalError("no fit with a change of such a size");
  }
  now_.last = {times.span, fitted};
  return fitted;
}

void ChangeFit::take_times(
    const std::function<ChangeTimes(const ChangeEffect&, const Fits&)>& search) {
  const std::shared_ptr<const Effect> effect = now_.spec.effects.back();  // fit() replaces it
  now_.times = search(*as_change(*effect), [&](const ChangeTimes& times) { return fit(times); });
  now_.stage = fit(now_.times);
}

void ChangeFit::refine_times() {
  take_times([&](const ChangeEffect& effect, const Fits& fits) {
    return refined_times(recordings_, now_.stage, effect, now_.times, fits);
  });
}

void ChangeFit::refine_by_refits(const ChangeSpan& near) {
  take_times([&](const ChangeEffect& effect, const Fits& fits) {
    return times_by_refits(recordings_, effect, {.span = near}, fits);
  });
  refine_times();
}

void ChangeFit::take_one_end() {
  if (!now_.times.span.begin.finite() || !now_.times.span.end.finite()) return;
  const State before = now_;
  const auto paid = [&](const State& state) {
    return state.stage.result().cost_final + cost_of_times(state.times, recordings_);
  };
  const auto as_likely = [&](const ChangeTimes& times) {
    now_.times = times;
    now_.stage = fit(times);
    return now_.stage.result().converged() && paid(now_) <= paid(before);
  };
  ChangeTimes lasting = before.times, from_the_start = before.times;
  lasting.span.end = kToTheEnd;
  lasting.sigma_s[1] = lasting.width_s[1] = 0.0;
  from_the_start.span.begin = kFromTheStart;
  from_the_start.sigma_s[0] = from_the_start.width_s[0] = 0.0;
  for (const ChangeTimes& times : {lasting, from_the_start}) {
    if (attempt([&] { return as_likely(times); }).value_or(false)) return;
    now_ = before;
  }
}

void ChangeFit::take_both_ends() {
  const std::optional<ChangeSpan> both =
      with_both_ends(recordings_, now_.stage, change(), now_.times.span);
  if (!both) return;
  const State before = now_;
  const auto better = [&] {
    move_to(*both, now_.start);
    refine_times();
    const double paid =
        cost_of_times(now_.times, recordings_) - cost_of_times(before.times, recordings_);
    return now_.stage.result().converged() &&
           now_.stage.result().cost_final + paid + kDraw < before.stage.result().cost_final;
  };
  if (!attempt(better).value_or(false)) now_ = before;
}

Stage ChangeFit::fit_as(const std::string& name, ChangeForm form) {
  now_.spec.effects.back() = make_change(name, form, now_.times.span);
  now_.start = {};
  now_.last.reset();
  return fit(now_.times);
}

// With a nat for each number, which is what chance explains.
double ChangeFit::cost_as(ChangeForm form) {
  const std::string name = change().name();
  const std::optional<Stage> fitted = attempt([&] { return fit_as(name, form); });
  return fitted && fitted->result().converged() ? fitted->result().cost_final + size_of(form)
                                                : double(INFINITY);
}

// May a form with more numbers explain more than these cost? By one step, which promises more than
// a fit gives and takes a fraction of its time.
bool ChangeFit::may_be_richer() const {
  const std::string& name = change().name();
  const ChangeForm richest = richest_form(name);
  if (change().form() == richest) return false;
  const Scan scan(recordings_, now_.stage, {make_change(name, richest, now_.times.span)});
  const Score& more = scan.scores().front();
  return 0.5 * more.statistic - double(more.dof) > kDraw;
}

void ChangeFit::take_better_form() {
  if (!may_be_richer()) return;
  const std::string name = change().name();
  const ChangeForm given = change().form(), richest = richest_form(name);
  const State before = now_;
  const double less = now_.stage.result().cost_final + size_of(given) - kDraw;
  ChangeForm best = richest;
  double least = cost_as(richest);
  // Where the richest explains no more, none does.
  for (const ChangeForm form : forms_of_change(name)) {
    if (!(least < less)) break;
    if (form == given || form == richest) continue;
    if (const double cost = cost_as(form); cost < least) {
      least = cost;
      best = form;
    }
  }
  const auto better = [&] {
    now_.stage = fit_as(name, best);
    refine_times();
    return now_.stage.result().converged();
  };
  if (!(least < less) || !attempt(better).value_or(false)) now_ = before;
}

void ChangeFit::take_bias_alone() {
  const std::string bias = bias_change_of(change().channel());
  const ChangeForm given = change().form();
  const bool known =
      std::ranges::any_of(from_.spec().effects, [&](const auto& e) { return e->name() == bias; });
  if (given == ChangeForm::kOffset || !has_offset(given) || known || !stays(bias)) return;
  const State before = now_;
  const double all = now_.stage.result().cost_final;
  const auto as_good = [&] {
    now_.stage = fit_as(bias, ChangeForm::kOffset);
    // Gains make up for times that are a little off: the bias gets times of its own, where it is
    // most of the change.
    const double its = now_.stage.result().cost_final;
    if (cost_without_ - its < kMost * (cost_without_ - all)) return false;
    refine_times();
    const Result& result = now_.stage.result();
    return result.converged() &&
           result.cost_final + size_of(ChangeForm::kOffset) < all + size_of(given) + kDraw;
  };
  if (!attempt(as_good).value_or(false)) now_ = before;
}

void ChangeFit::move_to(const ChangeSpan& span, const VectorXd& start) {
  now_.start = start;
  now_.times = {.span = span};
  now_.stage = fit(now_.times);
}

}  // namespace magimu
