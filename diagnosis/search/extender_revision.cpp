// SPDX-License-Identifier: BSD-3-Clause
// What entered first was found and measured without what came later.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnosis/held/held_out_nll.h"
#include "diagnosis/search/change_fit.h"
#include "diagnosis/search/extender.h"
#include "diagnosis/search/finding_text.h"
#include "diagnosis/search/scan_options.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

// Of a recording, a standard deviation of a time: one of which nothing is known has 0.29.
constexpr double kHardlyTold = 0.1;

// s: the largest standard deviation of when a change begins or ends.
double time_known_to(const Finding& change) {
  double out = 0.0;
  for (const FoundParameter& p : change.parameters) {
    if ((p.name == "t0" || p.name == "t1") && std::isfinite(p.value)) out = std::max(out, p.sigma);
  }
  return out;
}

}  // namespace

// Takes out what is no longer needed beside the effect that entered last: what predicts left-out
// data as well without it.
void Extender::prune() {
  for (std::size_t e = 0; e + 1 < stage_->spec().effects.size();) {
    const std::string name = stage_->spec().effects[e]->name();
    const auto finding = std::find_if(d_.findings.begin(), d_.findings.end(),
                                      [&](const Finding& f) { return f.effect == name; });
    ModelSpec spec = stage_->spec();
    spec.effects.erase(spec.effects.begin() + std::ptrdiff_t(e));
    if (finding != d_.findings.end()) {
      const double paid = entered_[name].searched;
      const auto in_quarters = [&](const Stage& s) { return sum_of(held_out_nll(s, quarter_s())); };
      const auto leaves = [&] {
        const Stage without = pipeline_.refit_with_same_noise(*stage_, spec);
        const double nll = sum_of(held_out_nll(without));
        const bool as_good = without.result().converged() && nll - nll_ - paid < kMinGain &&
                             !(lasts(*stage_->spec().effects[e]) &&
                               in_quarters(without) - in_quarters(*stage_) > kMinGain);
        if (as_good) take(without, nll);
        return as_good;
      };
      if (attempt(leaves).value_or(false)) {
        d_.findings.erase(finding);
        continue;
      }
    }
    ++e;
  }
}

// By value: the model that has it goes. NOLINTNEXTLINE(performance-unnecessary-value-param)
bool Extender::name_simpler(std::size_t finding, std::shared_ptr<const Effect> named) {
  const double with_it = nll_ + entered_[named->name()].searched;
  ModelSpec spec = stage_->spec();
  std::erase(spec.effects, named);
  const Stage without = pipeline_.refit_with_same_noise(*stage_, spec);
  if (!without.result().converged()) return false;
  take(without, sum_of(held_out_nll(without)));
  std::vector<Option> options;
  for (const Option& o : scan_options(recordings_, *stage_, candidates(*stage_))) {
    if (o.rank < log10_level() && is_simpler(*o.effect, *named) && int(options.size()) < kTried) {
      options.push_back(o);
    }
  }
  const std::vector<Trial> found = trials(options);
  const auto best = std::ranges::min_element(found, {}, &Trial::nll);
  if (best == found.end()) return false;
  const double more = allowance(*best->option.effect, *named, nll_ - best->nll, nll_ - with_it);
  if (best->nll > with_it + more) return false;
  Finding f = describe(best->option, best->stage, best->nll, options,
                       VectorXd::Zero(best->option.effect->size()));
  f.probability = d_.findings[finding].probability;
  d_.findings[finding] = std::move(f);
  take(best->stage, best->nll);
  return true;
}

std::vector<Finding>::iterator Extender::finding_of(const ChangeEffect& change) {
  const auto time_of = [](const Finding& f, const char* name) {
    return std::ranges::find(f.parameters, name, &FoundParameter::name)->value;
  };
  return std::ranges::find_if(d_.findings, [&](const Finding& f) {
    return f.effect == change.name() && time_of(f, "t0") == change.span().begin.t &&
           time_of(f, "t1") == change.span().end.t;
  });
}

// The model with the change as it was fitted now, and what its finding says of it.
void Extender::set_change(const ChangeFit& fit, Finding& finding) {
  const std::string& name = fit.change().name();
  // Parameters that were about as likely belong to other times.
  entered_[name] = {VectorXd(), entered_[finding.effect].searched};
  take(fit.stage(), sum_of(held_out_nll(fit.stage())));
  finding.effect = name;
  finding.parameters.clear();
  const ActiveEffect now = summary(*stage_).effects.back();
  const std::vector<Effect::Parameter>& own = fit.change().description().parameters;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const ActiveEffect::Parameter& p = now.parameters[i];
    finding.parameters.push_back({own[i].name, p.value, std::max(p.sigma, p.sigma_model), p.unit});
  }
  add_times(fit.times().span, fit.times().sigma_s, finding);
}

// Does one of two changes, its times its own again, explain kAsMuch of what both do? Then the other
// goes. A magnet takes a while to come, and a change of gains a little later may be what is left of
// that.
bool Extender::one_of_two_changes_is_enough(std::size_t one, std::size_t other) {
  const Stage both = *stage_;
  const auto effects = both.spec().effects;
  ModelSpec spec = both.spec();
  std::erase(spec.effects, effects[one]);
  std::erase(spec.effects, effects[other]);
  const double neither = pipeline_.refit_with_same_noise(both, spec).result().cost_final;
  spec.effects.push_back(effects[one]);
  const Stage alone = pipeline_.refit_with_same_noise(both, spec);
  ChangeFit fit(recordings_, pipeline_, alone, alone, as_change(*effects[one])->span(), {},
                INFINITY);
  fit.refine_times();
  const Result& result = fit.stage().result();
  if (!result.converged() ||
      neither - result.cost_final < kAsMuch * (neither - both.result().cost_final)) {
    return false;
  }
  const auto finding = [&](const Effect& effect) { return finding_of(*as_change(effect)); };
  const auto kept = finding(*effects[one]);
  if (kept == d_.findings.end() || finding(*effects[other]) == d_.findings.end()) return false;
  set_change(fit, *kept);
  d_.findings.erase(finding(*effects[other]));
  return true;
}

// Of two changes of one sensor that begin or end together the one that nearly suffices, the plainer
// first.
void Extender::join_changes() {
  const auto& effects = stage_->spec().effects;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    for (std::size_t j = 0; j < effects.size(); ++j) {
      const ChangeEffect* plain = as_change(*effects[i]);
      const ChangeEffect* rich = as_change(*effects[j]);
      if (plain == nullptr || rich == nullptr || plain->channel() != rich->channel()) continue;
      if (plain->size() >= rich->size() || !moment_in_common(plain->span(), rich->span())) {
        continue;
      }
      const bool joined =
          attempt([&] {
            return one_of_two_changes_is_enough(i, j) || one_of_two_changes_is_enough(j, i);
          }).value_or(false);
      if (joined) return;
    }
  }
}

// Replaces these effects by one change, where it explains as much, with a nat for each number less
// (and kDraw).
bool Extender::one_change_for(const std::vector<std::shared_ptr<const Effect>>& replaced,
                              const std::string& name, ChangeForm form, const ChangeSpan& span) {
  const Stage before = *stage_;
  const auto finding = [&](const Effect& effect) {
    const ChangeEffect* change = as_change(effect);
    return change != nullptr ? finding_of(*change)
                             : std::ranges::find(d_.findings, effect.name(), &Finding::effect);
  };
  ModelSpec spec = before.spec();
  int numbers = 0;
  for (const auto& e : replaced) {
    if (finding(*e) == d_.findings.end()) return false;
    numbers += e->size();
    std::erase(spec.effects, e);
  }
  const Stage without = pipeline_.refit_with_same_noise(before, spec);
  spec.effects.push_back(make_change(name, form, span));
  const Stage with = pipeline_.refit_with_same_noise(without, spec);
  ChangeFit fit(recordings_, pipeline_, without, with, span, {}, without.result().cost_final);
  fit.refine_times();
  fit.take_better_form();
  const Result& result = fit.stage().result();
  const double fewer = numbers - fit.change().size();
  if (!result.converged() || result.cost_final > before.result().cost_final + fewer + kDraw) {
    return false;
  }
  Finding named = *finding(*replaced.front());
  for (const auto& e : replaced) {
    const auto old = finding(*e);
    named.gain.heldout_nll_before =
        std::max(named.gain.heldout_nll_before, old->gain.heldout_nll_before);
    d_.findings.erase(old);
  }
  named.channel = to_string(fit.change().channel());
  set_change(fit, named);
  named.gain.heldout_nll_after = nll_;
  d_.findings.push_back(std::move(named));
  return true;
}

// Two sensors that turn by the same at the same moment: the third one turned, in whose frame they
// are told. (What it was thought to have itself goes with them.)
bool Extender::name_third_sensor(std::size_t one, std::size_t other) {
  const auto& effects = stage_->spec().effects;
  const ChangeEffect *first = as_change(*effects[one]), *second = as_change(*effects[other]);
  if (first == nullptr || second == nullptr || first->channel() == second->channel()) return false;
  if (first->form() == ChangeForm::kOffset || second->form() == ChangeForm::kOffset) return false;
  const std::optional<Moment> moment = moment_in_common(first->span(), second->span());
  if (!moment) return false;
  const std::string& third = *std::ranges::find_if(change_names(), [&](const std::string& name) {
    const Sensor channel = find_effect(name)->channel();
    return channel != first->channel() && channel != second->channel() &&
           richest_form(name) != ChangeForm::kOffset;
  });
  std::vector<std::shared_ptr<const Effect>> replaced = {effects[one], effects[other]};
  std::ranges::copy_if(effects, std::back_inserter(replaced),
                       [&](const auto& e) { return e->name() == third; });
  return one_change_for(replaced, third, ChangeForm::kTurn, {*moment, kToTheEnd});
}

// Gains that are others from a moment on, and others throughout: they were others until then.
bool Extender::name_complement(std::size_t change, std::size_t throughout) {
  const auto& effects = stage_->spec().effects;
  const ChangeEffect* const lasting = as_change(*effects[change]);
  if (lasting == nullptr || lasting->form() == ChangeForm::kOffset) return false;
  const Effect& matrix = *effects[throughout];
  if (matrix.channel() != lasting->channel() || !matrix.name().ends_with("_scale_misalignment")) {
    return false;
  }
  const ChangeSpan& span = lasting->span();
  if (span.begin.finite() == span.end.finite()) return false;
  const ChangeSpan complement =
      span.begin.finite() ? ChangeSpan{kFromTheStart, span.begin} : ChangeSpan{span.end, kToTheEnd};
  return one_change_for({effects[change], effects[throughout]}, lasting->name(), lasting->form(),
                        complement);
}

bool Extender::name_one_change() {
  const std::size_t n = stage_->spec().effects.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const auto one = [&] { return (i < j && name_third_sensor(i, j)) || name_complement(i, j); };
      if (attempt(one).value_or(false)) return true;
    }
  }
  return false;
}

// Times and form of every change once more beside what came later, and with the noise as it is now:
// what was not in the model has moved them, and told by too large a noise no time is certain.
void Extender::refine_changes() {
  const std::vector<std::shared_ptr<const Effect>> effects = stage_->spec().effects;
  for (const auto& effect : effects) {
    const ChangeEffect* change = as_change(*effect);
    if (change == nullptr) continue;
    const auto finding = finding_of(*change);
    if (finding == d_.findings.end()) continue;
    attempt([&] {
      ModelSpec spec = stage_->spec();
      std::erase(spec.effects, effect);
      spec.effects.push_back(effect);
      const Stage last = pipeline_.refit_with_same_noise(*stage_, spec);
      ChangeFit fit(recordings_, pipeline_, last, last, change->span(), {}, INFINITY);
      fit.refine_times();
      fit.take_one_end();
      fit.take_better_form();
      fit.take_bias_alone();
      if (fit.stage().result().converged()) set_change(fit, *finding);
      return true;
    });
  }
}

// Replaces two findings by one of the first one's class that explains as much as both, with a nat
// for each parameter that it needs less (and kDraw). For example a lag, which was first taken for
// an offset, and then for a second cause that explains what the offset left of it.
bool Extender::name_one_for_two(std::size_t first, std::size_t second) {
  const Stage both = *stage_;
  const auto effect_of = [&](std::size_t finding) {
    return *std::ranges::find(both.spec().effects, d_.findings[finding].effect,
                              [](const auto& e) { return e->name(); });
  };
  const std::shared_ptr<const Effect> one = effect_of(first), other = effect_of(second);
  ModelSpec spec = both.spec();
  std::erase(spec.effects, one);
  std::erase(spec.effects, other);
  const Stage without = pipeline_.refit_with_same_noise(both, spec);
  if (!without.result().converged()) return false;
  take(without, sum_of(held_out_nll(without)));
  std::vector<Option> options = scan_options(recordings_, *stage_, candidates(*stage_));
  std::erase_if(options, [&](const Option& o) {
    return o.effect->name() == one->name() || !same_class(*o.effect, *one);
  });
  const std::vector<Trial> found = trials(options);
  const auto best = std::ranges::min_element(
      found, {}, [](const Trial& t) { return t.stage.result().cost_final; });
  if (best == found.end()) return false;
  const int fewer = one->size() + other->size() - best->option.effect->size();
  if (best->stage.result().cost_final > both.result().cost_final + fewer + kDraw) return false;
  Finding f = describe(best->option, best->stage, best->nll, options,
                       VectorXd::Zero(best->option.effect->size()));
  f.probability = d_.findings[first].probability;
  d_.findings[first] = std::move(f);
  d_.findings.erase(d_.findings.begin() + std::ptrdiff_t(second));
  take(best->stage, best->nll);
  return true;
}

// Replaces a change whose time is hardly told by an error that is the same throughout, where that
// explains as much: every part has such errors, and hardly any sensor moves on its board while it
// is turned. Where the attitudes before and after differ little, such a change imitates them. (One
// at a time that is known is none of them, however well a matrix imitates it where each attitude is
// taken once or twice.)
bool Extender::name_lasting(const std::shared_ptr<const Effect>& named) {
  const ChangeEffect* const change = as_change(*named);
  if (change == nullptr || finding_of(*change) == d_.findings.end()) return false;
  if (time_known_to(*finding_of(*change)) < kHardlyTold * longest_s(recordings_)) return false;
  const Stage with = *stage_;
  ModelSpec spec = with.spec();
  std::erase(spec.effects, named);
  const Stage without = pipeline_.refit_with_same_noise(with, spec);
  if (!without.result().converged()) return false;
  take(without, sum_of(held_out_nll(without)));
  std::vector<Option> options = scan_options(recordings_, *stage_, candidates(*stage_));
  // One step promises about what a fit gives.
  const double gain = without.result().cost_final - with.result().cost_final;
  std::erase_if(options, [&](const Option& o) {
    return as_change(*o.effect) != nullptr || !lasts(*o.effect) ||
           0.5 * o.score.statistic < kMost * gain;
  });
  const std::vector<Trial> found = trials(options);
  const auto best = std::ranges::min_element(
      found, {}, [](const Trial& t) { return t.stage.result().cost_final; });
  if (best == found.end()) return false;
  if (best->stage.result().cost_final > with.result().cost_final + kDraw) return false;
  const auto finding = finding_of(*change);
  Finding f = describe(best->option, best->stage, best->nll, options,
                       VectorXd::Zero(best->option.effect->size()));
  f.probability = finding->probability;
  *finding = std::move(f);
  take(best->stage, best->nll);
  return true;
}

// The first findings entered while the later ones were not in the model, and may have explained a
// part of these, too. Where a simpler cause now predicts as well, it replaces the richer one.
void Extender::reconsider() {
  while (name_one_change()) {
  }
  const std::vector<std::shared_ptr<const Effect>> all = stage_->spec().effects;
  for (const auto& effect : all) {
    const Stage stage = *stage_;
    const double nll = nll_;
    if (!attempt([&] { return name_lasting(effect); }).value_or(false)) take(stage, nll);
  }
  const auto in_model = [&](std::size_t finding) -> std::shared_ptr<const Effect> {
    for (const auto& e : stage_->spec().effects) {
      if (e->name() == d_.findings[finding].effect) return e;
    }
    return nullptr;
  };
  for (std::size_t i = 0; i < d_.findings.size(); ++i) {
    for (std::size_t j = i + 1; j < d_.findings.size(); ++j) {
      const auto one = in_model(i), other = in_model(j);
      if (!one || !other || one->channel() != other->channel()) continue;
      const auto of_class = [&](const auto& e) { return same_class(*e, *one); };
      if (std::ranges::none_of(candidates(*stage_), of_class)) continue;
      const Stage stage = *stage_;
      const double nll = nll_;
      if (attempt([&] { return name_one_for_two(i, j); }).value_or(false)) break;
      take(stage, nll);
    }
  }
  for (std::size_t i = 0; i + 1 < d_.findings.size(); ++i) {
    const auto& effects = stage_->spec().effects;
    const auto named = std::find_if(effects.begin(), effects.end(), [&](const auto& e) {
      return e->name() == d_.findings[i].effect;
    });
    if (named == effects.end()) continue;
    const auto simpler = [&](const auto& e) { return is_simpler(*e, **named); };
    if (std::ranges::none_of(candidates(*stage_), simpler)) continue;
    const Stage stage = *stage_;
    const double nll = nll_;
    if (!attempt([&] { return name_simpler(i, *named); }).value_or(false)) take(stage, nll);
  }
}

std::optional<Stage> Extender::without(std::size_t effect) const {
  ModelSpec spec = stage_->spec();
  spec.effects.erase(spec.effects.begin() + std::ptrdiff_t(effect));
  return attempt([&] { return pipeline_.refit_with_same_noise(*stage_, spec); });
}

void Extender::keep_named() {
  const auto of_base = [&](const std::string& name) {
    return std::ranges::any_of(base_->spec().effects,
                               [&](const auto& e) { return e->name() == name; });
  };
  const auto is_named = [&](const std::string& name) {
    return std::ranges::find(d_.findings, name, &Finding::effect) != d_.findings.end();
  };
  // The mean age of samples whose clock is told in the samples alone.
  const auto of_clock = [&](const std::string& name) {
    return is_lag(name) && is_named("mag_own_clock");
  };
  for (std::size_t e = 0; e < stage_->spec().effects.size();) {
    const std::string name = stage_->spec().effects[e]->name();
    if (is_named(name) || of_base(name) || of_clock(name)) {
      ++e;
      continue;
    }
    const std::optional<Stage> less = without(e);
    if (!less || !less->result().converged()) return;
    replace(*less);
  }
}

// The density of a walk from its states in a fit, their prior taken off.
RandomWalk Extender::walk_in(const Stage& stage, std::size_t effect) const {
  const Effect& walk = *stage.spec().effects[effect];
  const double duration = longest_s(recordings_);
  const Score s = wald_test(stage, effect);
  MatrixXd of_data = s.information;
  of_data.diagonal() -= walk.prior_sigma(duration).cwiseAbs2().cwiseInverse();
  return estimate_random_walk(of_data, s.information * s.theta,
                              make_gyro_bias_walk(walk.size() / 3, 1.0)->prior_sigma(duration));
}

double Extender::explains(const Stage& with, std::size_t effect, const Stage& without,
                          double searched) const {
  if (with.spec().effects[effect]->description().random_process) {
    return 0.5 * walk_in(with, effect).likelihood_ratio;
  }
  const auto parameters = [](const Stage& stage) {
    int n = 0;
    for (const auto& e : stage.spec().effects) n += e->size();
    return n;
  };
  return without.result().cost_final - with.result().cost_final -
         (parameters(with) - parameters(without)) - searched;
}

double Extender::worth(std::size_t effect, const Stage& without) const {
  const auto entered = entered_.find(stage_->spec().effects[effect]->name());
  return explains(*stage_, effect, without,
                  entered == entered_.end() ? 0.0 : entered->second.searched);
}

// A walk's density was estimated when it entered, with all that later findings explain: it is
// estimated anew beside these.
void Extender::estimate_walk_anew() {
  ModelSpec spec = stage_->spec();
  const auto walk = std::ranges::find_if(
      spec.effects, [](const auto& e) { return e->description().random_process; });
  if (walk == spec.effects.end() || *walk == spec.effects.back()) return;
  const auto finding = std::ranges::find_if(
      d_.findings, [&](const Finding& f) { return f.effect == (*walk)->name(); });
  if (finding == d_.findings.end()) return;
  const RandomWalk now = walk_in(*stage_, std::size_t(walk - spec.effects.begin()));
  if (!(now.density > 0.0)) return;
  *walk = make_gyro_bias_walk((*walk)->size() / 3, now.density);
  const auto replaced = [&] {
    const Stage stage = pipeline_.refit_with_same_noise(*stage_, spec);
    if (stage.result().converged()) replace(stage);
    return stage.result().converged();
  };
  if (!attempt(replaced).value_or(false)) return;
  finding->parameters.front().value = now.density;
  finding->parameters.front().sigma = now.sigma;
  finding->sentence = walk_sentence(finding->parameters.front());
}

void Extender::restate(const Calibration& after) {
  const auto& effects = stage_->spec().effects;
  const std::size_t chosen = after.effects.size() - effects.size();  // by the pipeline, before them
  for (std::size_t e = 0; e < effects.size(); ++e) {
    const Effect& effect = *effects[e];
    // A walk has a density, a field of the place a size; a line of the mains and a clock were
    // measured in the samples.
    if (effect.description().proper_prior || effect.name() == "mains_interference" ||
        effect.name() == "mag_own_clock") {
      continue;
    }
    const auto same = [&](const auto& f) { return f->name() == effect.name(); };
    auto before = std::count_if(effects.begin(), effects.begin() + std::ptrdiff_t(e), same);
    const auto finding = std::ranges::find_if(
        d_.findings, [&](const Finding& f) { return f.effect == effect.name() && before-- == 0; });
    if (finding == d_.findings.end()) continue;
    const auto entered = entered_.find(effect.name());
    VectorXd apart = VectorXd::Zero(effect.size());
    if (entered != entered_.end() && entered->second.apart.size() > 0)
      apart = entered->second.apart;
    VectorXd theta(effect.size()), sigma(effect.size());
    for (int i = 0; i < effect.size(); ++i) {
      const ActiveEffect::Parameter& p = after.effects[chosen + e].parameters[std::size_t(i)];
      theta[i] = p.value;
      sigma[i] = std::max({p.sigma, p.sigma_model, apart[i]});
      finding->parameters[std::size_t(i)].value = theta[i];
      finding->parameters[std::size_t(i)].sigma = sigma[i];
    }
    finding->sentence = effect.sentence(theta, sigma);
  }
}

}  // namespace magimu
