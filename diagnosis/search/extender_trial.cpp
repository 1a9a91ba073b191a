// SPDX-License-Identifier: BSD-3-Clause
// One option in the model: what it must pass before it may be compared with the others.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calibration/model/extension.h"
#include "calibration/model/parameter_names.h"
#include "calibration/motion/random_walk.h"
#include "calibration/motion/rests/rests.h"
#include "diagnosis/held/held_out_nll.h"
#include "diagnosis/search/change_fit.h"
#include "diagnosis/search/extender.h"
#include "diagnosis/search/shapes/passing_field.h"
#include "diagnosis/search/shapes/source_search.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kPutDown = 5.0;        // s about the ends of a rest
constexpr double kOfPlaces = 5.0;       // uT: two places in a room hardly differ by more
constexpr double kCare = 2.0;           // log10 of a probability, where noise is coloured
constexpr double kNoStep = -6.0;        // log10 of the probability of what is left beside a change
constexpr double kSharp = 4.0;          // times the changes at other times
constexpr double kBent = 2.0;           // residuals over their noise
constexpr double kColour = 0.15;        // correlation of neighbouring nodes' residuals
constexpr double kBends = 400.0;        // statistic of a source that bends the trajectory
constexpr double kContradiction = 1.0;  // distance of halves over the effect, squared: one has none
constexpr double kHardlyAny = 0.1;      // of the squares, with a cause that is all there is

// Does the fit leave far more than noise? Then it has followed what it should not.
bool is_bent(const Stage& stage) {
  const SensorSums sums = stage.sums();
  return std::ranges::any_of(kSensors, [&](Sensor s) { return sums.rms(s) > kBent; });
}

// Of the field that the calibration says, by what it makes of a unit field.
double strength_uT(const Stage& stage) {
  return std::cbrt(std::abs(stage.result().values.at<Matrix3>(key::distortion).determinant()));
}

}  // namespace

VectorXd Extender::Trial::parameters() const {
  return effect_parameters(stage.result().values, effect_keys(stage.spec().effects).back());
}

// How much larger the noise is than the model's, by single samples and by rests.
KnownScatter Extender::excess(Sensor channel, const Stage& stage) const {
  const double white = in_samples_[std::size_t(channel)];
  return {white, std::max(1.0, at_rest_.excess(channel, stage.spec().noise) / white)};
}

// A change of the bias by less than half a step of a coarse converter: where the sensor rests or
// turns slowly, rounding alone makes such changes.
bool Extender::is_rounding(const Option& option, const Stage& stage) const {
  const Effect& effect = *option.effect;
  const bool of_field = is_field_change(effect);
  if (!(step_uT_ > 0.0) || !(is_magnet(effect) || of_field || effect.name() == "hard_iron_drift")) {
    return false;
  }
  const VectorXd theta =
      effect_parameters(stage.result().values, effect_keys(stage.spec().effects).back());
  const double unit_uT = of_field ? strength_uT(stage) : 1.0;
  return unit_uT * theta.cwiseAbs().maxCoeff() < 0.5 * step_uT_;
}

// Is it there in the refitted model, too, under noise as it is?
bool Extender::survives(Option& option, const Stage& stage, const Score& w) const {
  if (is_rounding(option, stage)) return false;
  const double level = log10_level();
  if (option.effect->description().random_process) {
    // Without the random walk in the model its drift looks like coloured noise, so the scatter of
    // the fit with the walk is used.
    const Score& s = option.score;
    option.score.log10_p = estimate_random_walk(s.information, s.information * s.theta,
                                                option.effect->prior_sigma(longest_s(recordings_)),
                                                in_samples_[std::size_t(option.effect->channel())] *
                                                    (w.coloured ? w.scatter : 1.0))
                               .log10_p;
    return option.score.log10_p < level - (w.coloured ? kCare : 0.0);
  }
  const double penalty =
      std::max(0.0, option.rank - log10_chi_square_tail(option.score.statistic, option.score.dof));
  const bool of_time = option.effect->with_terms(1) != nullptr;
  // What leaves hardly anything is no shape that noise happened to have: windows that scatter, as
  // they do for what is there in some of them, say no more of it.
  const bool is_all_there_is =
      !of_time && stage.result().cost_final < kHardlyAny * stage_->result().cost_final;
  if (is_all_there_is) {
    option.score.log10_p = option.rank;
  } else {
    option.score.log10_p = std::min(0.0, w.log10_p + penalty);
    // The F distribution's far tail is not to be trusted as far as that of white noise.
    if (option.score.log10_p > level - (w.coloured ? kCare : 0.0)) return false;
  }
  if (is_change(option.effect->name())) {
    if (!is_all_there_is) {
      // Too few windows have the change to show their scatter: that of the others is used.
      const double by_others = log10_p_by_scatter_of(stage, key::bias_of(option.effect->channel()),
                                                     option.score.statistic, option.score.dof);
      option.score.log10_p = std::max(option.score.log10_p, by_others + penalty);
      if (option.score.log10_p > level) return false;
    }
    if (is_magnet(*option.effect)) return sharpness(option, stage) > kSharp;
    // Blocks that are cut from each other turn their attitudes until the field is as it was.
    if (as_change(*option.effect)->form() == ChangeForm::kOffset &&
        !is_field_change(*option.effect) && log10_p_by_blocks(stage) + penalty > level) {
      return false;
    }
    return stands_out(option, stage, w.statistic);
  }
  return of_time ||
         contradiction_of_halves(stage, stage.spec().effects.size() - 1) < kContradiction;
}

// How much better left-out data are predicted than by the model without the effect, in nats. In the
// hand-held model both are refitted with a new estimate of the reach if there is no gain without
// that: an error of the accelerometer makes the hand seem to reach further than it did.
double Extender::gain(LeftOut& left_out, std::optional<double> window_s) const {
  const auto nll = [&](const Stage& s) {
    return sum_of(window_s ? held_out_nll(s, *window_s) : held_out_nll(s));
  };
  const double out = (window_s ? nll(*stage_) : nll_) - nll(left_out.stage);
  if (out > kMinGain || !is_moved(left_out.stage.spec().motion)) return out;
  // Without a fit with the reach estimated anew, the one that there is counts.
  const auto refit = [&](const Stage& s) {
    return attempt([&] { return pipeline_.refit(s, s.spec()); });
  };
  {
    const std::lock_guard lock(refitting_);
    if (!refitted_) refitted_ = refit(*stage_);
  }
  if (!left_out.refitted) left_out.refitted = refit(left_out.stage);
  if (!refitted_ || !left_out.refitted || !left_out.refitted->result().converged()) return out;
  return std::max(out, nll(*refitted_) - nll(*left_out.refitted));
}

// Of a recording of mean length.
double Extender::quarter_s() const {
  double sum = 0.0;
  for (const Recording* r : recordings_) sum += r->duration_s();
  return 0.25 * sum / double(recordings_.size());
}

// Of the last effect by its robust standard deviations. Coloured noise of a sensor that the
// trajectory follows makes slow errors of the attitude, of which the windows' scatter shows little.
double Extender::log10_p_by_blocks(const Stage& stage) const {
  const ActiveEffect last = summary(stage).effects.back();
  double squares = 0.0;
  for (const ActiveEffect::Parameter& p : last.parameters) {
    squares += std::pow(p.value / std::max({p.sigma, p.sigma_model, 1e-300}), 2);
  }
  return log10_chi_square_tail(squares, double(last.parameters.size()));
}

// With a change in the model, does no second one nearly as large remain? Slow errors of any kind
// look like changes at many times. A real change leaves no other.
bool Extender::stands_out(const Option& option, const Stage& stage, double statistic) const {
  const std::vector<LikelyChange> left =
      likely_changes(recordings_, stage, {option.effect->name()});
  return std::ranges::all_of(left, [&](const LikelyChange& other) {
    return other.log10_p() > kNoStep || kSharp * other.statistic < statistic;
  });
}

// With a step in the model, does the bias stay the same within the pieces? What changes in many
// ways is no step. (Coloured noise looks so.)
bool Extender::is_all(const Stage& stage) const {
  const std::vector<LikelyChange> left = likely_changes(recordings_, stage, {"hard_iron_change"});
  return std::ranges::all_of(left,
                             [](const LikelyChange& other) { return other.log10_p() > kNoStep; });
}

// Was the sensor put down or taken up then?
bool Extender::is_put_down(const Moment& at) const {
  const std::vector<int> fields = fields_of(recordings_);
  for (std::size_t r = 0; r < recordings_.size(); ++r) {
    if (fields[r] != at.recording) continue;
    const bool put_down = std::ranges::any_of(find_rests(*recordings_[r]), [&](const TimeSpan& s) {
      return std::abs(at.t - s.begin_s) < kPutDown || std::abs(at.t - s.end_s) < kPutDown;
    });
    if (put_down) return true;
  }
  return false;
}

// Of a change of gains that begins and ends: does whatever comes near and goes again explain as
// much with as many numbers? Gains that change for some seconds hardly exist; magnets that pass do.
bool Extender::passes_by(const Option& option, const Stage& stage) const {
  const ChangeEffect& change = *as_change(*option.effect);
  const ChangeSpan& span = option.span;
  if (change.form() == ChangeForm::kOffset || !span.begin.finite() || !span.end.finite() ||
      span.begin.recording != span.end.recording) {
    return false;
  }
  const auto explains_as_much = [&](bool beside_the_sensor) {
    ModelSpec spec = stage.spec();
    spec.effects.back() = make_passing_field(span, beside_the_sensor);
    const int numbers = spec.effects.back()->size();
    const std::optional<Stage> passing = attempt(
        [&] { return pipeline_.refit_with_same_noise(*stage_, spec, VectorXd::Zero(numbers)); });
    if (!passing || !passing->result().converged()) return false;
    const VectorXd theta =
        effect_parameters(passing->result().values, effect_keys(spec.effects).back());
    return !is_beyond_parts(*spec.effects.back(), theta) &&
           passing->result().cost_final + numbers <
               stage.result().cost_final + option.effect->size() + kDraw;
  };
  return explains_as_much(true) || explains_as_much(false);
}

// The times of a change, and the fit with them. Under coloured noise a change is believed where
// neither begins nor ends a rest, unless it is a large one: there the sensor was put down or taken
// up, and the field of the two places differs. False where no change is left.
bool Extender::find_times(Option& option, Stage& stage, bool& may_refit) const {
  const Sensor channel = option.effect->channel();
  ChangeFit fit(recordings_, pipeline_, *stage_, stage, option.span, option.start,
                stage_->result().cost_final);
  fit.refine_times();
  if (!explains_most(fit.stage()) && is_hopeless(option, fit.stage())) return false;
  fit.take_both_ends();
  fit.take_one_end();
  // It was chosen at the times of windows.
  fit.take_better_form();
  fit.take_bias_alone();
  const auto is_offset = [&] { return fit.change().form() == ChangeForm::kOffset; };
  // Once a model: it takes a dozen fits and more. What a hand's motion has followed of a change of
  // the accelerometer keeps steps from leading to its times.
  const bool followed = channel == Sensor::kAcc && is_moved(stage.spec().motion);
  const bool is_far = is_offset() ? is_bent(fit.stage()) : followed && explains_most(fit.stage());
  if (is_far && fit.stage().result().converged() && may_refit) {
    may_refit = false;
    fit.refine_by_refits(is_offset() ? option.span : fit.times().span);
    fit.take_bias_alone();  // nothing, of a bias
  }
  const bool offset = is_offset();
  const ChangeTimes found = fit.times();
  stage = fit.stage();
  ChangeSpan span = found.span;
  std::array<double, 2> sigma_t = found.sigma_s;
  // A change whose times all lie outside of the recordings is none.
  const auto is_inside = [&](const Moment& at) {
    const Moment beginning{0, recordings_.front()->gyr.t.front()};
    const Moment ending{int(recordings_.size()) - 1, recordings_.back()->gyr.t.back()};
    return at.finite() && at > beginning && at < ending;
  };
  if (!is_inside(span.begin) && !is_inside(span.end)) return false;
  if (!offset && !turns(stage, span, false)) return false;
  // With wrong times white noise, too, scatters widely; with the right ones only what is coloured.
  const VectorXd theta = fit.parameters();
  const bool of_field = is_field_change(*option.effect);
  const double unit_uT = offset && !of_field ? 1.0 : strength_uT(stage);
  const auto coloured = [&](const Stage& fitted) {
    const Score w = wald_test(fitted, fitted.spec().effects.size() - 1, excess(channel, fitted));
    return (w.coloured && !w.by_chance) || fitted.sums().lag1[std::size_t(Sensor::kMag)] > kColour;
  };
  // A lasting change of gains shows wherever the sensor turns, not only on the way to where it
  // lies. Nor is another place all there is to a change of the bias where it turns both before and
  // after, and longer than it takes to lay it there. (Gains take the field of many places.)
  const bool small = !offset || unit_uT * theta.norm() < kOfPlaces;
  const bool at_rests = is_put_down(span.begin) || is_put_down(span.end);
  const auto lies = [&](bool inside) { return !turns(stage, span, inside, kPutDown); };
  if (channel == Sensor::kMag && small && at_rests && (!offset || lies(true) || lies(false)) &&
      coloured(stage)) {
    // The noise is still that of the model without the change: too large, and what the trajectory
    // then leaves to the magnetometer is coloured.
    const std::optional<Stage> anew = attempt([&] { return pipeline_.refit(stage, stage.spec()); });
    if (!anew || coloured(*anew)) {
      if (is_put_down(span.begin)) span.begin = kFromTheStart;
      if (is_put_down(span.end)) span.end = kToTheEnd;
      // From the beginning to the end: nothing changed.
      if (!span.begin.finite() && !span.end.finite()) return false;
    }
  }
  // A lasting change is on where the bias is the larger: a magnet came or went.
  const Vector3 bias = stage.result().values.at<Vector3>(key::mag_bias);
  option.start = theta;
  if (offset && !of_field && !span.end.finite() && span.begin.finite() &&
      (bias + theta).norm() < bias.norm()) {
    span = {kFromTheStart, span.begin};
    option.start = -theta;
    std::swap(sigma_t[0], sigma_t[1]);
  }
  if (span.begin != found.span.begin || span.end != found.span.end) {
    fit.move_to(span, option.start);
    stage = fit.stage();
  }
  option.effect = stage.spec().effects.back();
  option.span = span;
  option.sigma_t = sigma_t;
  option.searched += cost_of_times(found, recordings_);
  return true;
}

// A strong source bends the trajectory of a fit without it, and what that leaves points elsewhere:
// once there is some source in the model, its place is looked for anew.
void Extender::find_source(Option& option, Stage& stage) const {
  for (const LikelySource& source : sources_by_residual(*recordings_.front(), stage)) {
    VectorXd start(6);
    start << source.place, source.moment;
    std::optional<Stage> again =
        attempt([&] { return pipeline_.refit_with_same_noise(*stage_, stage.spec(), start); });
    if (!again || !again->result().converged() ||
        again->result().cost_final > stage.result().cost_final) {
      continue;
    }
    stage = *std::move(again);
    option.start = start;
  }
}

bool Extender::explains_most(const Stage& with) const {
  return with.result().converged() &&
         with.result().cost_final < (1.0 - kMost) * stage_->result().cost_final;
}

// Do the last change of the fit and another one, by one step, explain most together, the first at
// least its half of that? Each keeps the other from standing out.
bool Extender::explains_most_of_two(const Stage& with) const {
  const double before = stage_->result().cost_final, after = with.result().cost_final;
  if (!with.result().converged() || !(after < (1.0 - 0.5 * kMost) * before)) return false;
  const std::vector<LikelyChange> left = likely_changes(recordings_, with, change_names());
  return std::ranges::any_of(left, [&](const LikelyChange& other) {
    return after - 0.5 * other.statistic < (1.0 - kMost) * before;
  });
}

// Is a change significant neither by its windows' scatter nor by its robust standard deviations?
// Then its times are not sought, which takes a dozen fits. A real change is significant by one of
// the two even at the time of a window: of simulated changes of all sensors p by the second was
// 1e-51 and less wherever the first said nothing.
bool Extender::is_hopeless(const Option& option, const Stage& stage) const {
  const Score w =
      wald_test(stage, stage.spec().effects.size() - 1, excess(option.effect->channel(), stage));
  const double penalty =
      std::max(0.0, option.rank - log10_chi_square_tail(option.score.statistic, option.score.dof));
  return w.log10_p + penalty >= 0.0 && log10_p_by_blocks(stage) + penalty > log10_level();
}

// The model with the option in it, fitted; nothing where it does not hold there.
// most: the option with its times, where it explains most of all squares though it holds or not.
std::optional<Extender::Trial> Extender::trial(Option option, bool& may_refit,
                                               std::optional<Option>& most) const {
  ModelSpec spec = stage_->spec();
  std::erase_if(spec.effects, [&](const auto& e) { return replaces(*option.effect, e->name()); });
  spec.effects.push_back(option.effect);
  Stage stage = pipeline_.refit_with_same_noise(*stage_, spec, option.start);
  if (is_change(option.effect->name()) && !is_magnet(*option.effect) && !explains_most(stage) &&
      is_hopeless(option, stage)) {
    return std::nullopt;
  }
  if (is_change(option.effect->name()) &&
      (!find_times(option, stage, may_refit) || passes_by(option, stage))) {
    return std::nullopt;
  }
  if (is_change(option.effect->name()) && (explains_most(stage) || explains_most_of_two(stage))) {
    most = option;
  }
  if (option.effect->name() == "stationary_source" && option.score.statistic > kBends) {
    find_source(option, stage);
  }
  if (!stage.result().converged()) return std::nullopt;
  const Score w =
      wald_test(stage, stage.spec().effects.size() - 1, excess(option.effect->channel(), stage));
  if (!survives(option, stage, w)) return std::nullopt;
  if (option.effect->description().random_process &&
      rests_contradict_walk(whole_, option.extra.front().value)) {
    return std::nullopt;
  }
  LeftOut left_out{stage, {}};
  // An error that lasts must help to predict whole quarters of the recording: what comes and goes
  // with the place where the sensor is held does not. So must a drift where noise is coloured.
  double gained = gain(left_out);
  const double nll = nll_ - gained;
  if (lasts(*option.effect) || (option.effect->with_terms(1) != nullptr && w.coloured)) {
    const double in_quarters = gain(left_out, quarter_s());
    if (in_quarters < kMinGain) return std::nullopt;
    if (lasts(*option.effect)) gained = std::max(gained, in_quarters);
  }
  if (option.effect->name() == "hard_iron_change" && !w.coloured && !is_all(stage)) {
    return std::nullopt;
  }
  return Trial{std::move(option), std::move(stage), nll, w.coloured && !w.by_chance, gained};
}

// In nats on all data. The density of a random process is a parameter, too.
double Extender::likelier(const Trial& t) const {
  const double density = t.option.effect->description().random_process ? 1.0 : 0.0;
  return explains(t.stage, t.stage.spec().effects.size() - 1, *stage_, t.option.searched) - density;
}

// Was the same change refused before, and is its statistic nearly the same now? Then a new trial
// would end as the last one.
bool Extender::was_refused(const Option& option) const {
  constexpr double kTheSame = 0.1;  // of its statistic
  return std::ranges::any_of(refused_changes_, [&](const Option& old) {
    return old.effect->name() == option.effect->name() &&
           as_change(*old.effect)->form() == as_change(*option.effect)->form() &&
           are_near(old.span, option.span) &&
           std::abs(option.score.statistic - old.score.statistic) < kTheSame * old.score.statistic;
  });
}

// Trials of the options that hold, predict left-out data better and stand beside the process that
// explains most. Trial::gain, by which the best is chosen, is of the likelihood of all data:
// windows that are cut from each other show little of what takes minutes. The options are tried in
// parallel, with the same result as one after another.
std::vector<Extender::Trial> Extender::trials(const std::vector<Option>& options) {
  struct Tried {
    std::optional<Trial> trial;
    std::optional<Option> most;
    bool refits_spent = false;
  };
  const auto tried = [&](const Option& o, bool may_refit) {
    Tried out;
    bool left = may_refit;
    // An option whose numbers fail is refused.
    out.trial = attempt([&] { return trial(o, left, out.most); }).value_or(std::nullopt);
    out.refits_spent = left != may_refit;
    return out;
  };
  const auto refused = [&](const Option& o) {
    return is_change(o.effect->name()) && was_refused(o);
  };
  std::vector<Tried> all(options.size());
  parallel::for_each(options.size(), [&](std::size_t i) {
    if (!refused(options[i])) all[i] = tried(options[i], !refits_spent_);
  });
  std::vector<Trial> out;
  for (std::size_t i = 0; i < options.size(); ++i) {
    const Option& o = options[i];
    if (refused(o)) continue;
    // In order, an option before this one would have spent the refits.
    if (all[i].refits_spent && refits_spent_) all[i] = tried(o, false);
    refits_spent_ |= all[i].refits_spent;
    std::optional<Trial>& t = all[i].trial;
    if (!t && is_change(o.effect->name())) refused_changes_.push_back(o);
    if (all[i].most) may_have_changed_.insert(all[i].most->effect->channel());
    if (!t && all[i].most) explain_most_.push_back(*std::move(all[i].most));
    if (!t || !(t->left_out - t->option.searched > kMinGain)) continue;
    t->alone = t->gain = attempt([&] { return likelier(*t); }).value_or(-INFINITY);
    if (std::isfinite(t->gain)) out.push_back(*std::move(t));
  }
  if (!out.empty()) judge_beside_process(out);
  std::erase_if(out, [](const Trial& t) { return !stands_beside_process(t); });
  return out;
}

}  // namespace magimu
