// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/extender.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/extension.h"
#include "calibration/general_dependence.h"
#include "calibration/parameter_names.h"
#include "calibration/random_walk.h"
#include "calibration/rests.h"
#include "calibration/summary.h"
#include "calibration/testable.h"
#include "calibration/trust.h"
#include "diagnosis/change_search.h"
#include "diagnosis/finding_text.h"
#include "diagnosis/held_out_nll.h"
#include "diagnosis/option.h"
#include "diagnosis/scan_options.h"
#include "diagnosis/source_search.h"
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr int kTried = 4;               // best candidates that are refitted
constexpr double kWorthTrying = 0.4;    // of the best candidate's statistic
constexpr double kMinGain = 1.0;        // nats on left-out data
constexpr double kDraw = 2.0;           // nats within which the simpler of two effects is taken
constexpr double kPutDown = 5.0;        // s about the ends of a rest
constexpr double kCare = 1.0;           // log10 of a probability
constexpr double kAsLikely = 4.0;       // nats within which a second answer counts as one
constexpr double kAsMuch = 0.85;        // of the gain, for a nested cause to be the one named
constexpr double kNoStep = -6.0;        // log10 of the probability of what is left beside a step
constexpr double kSharp = 4.0;          // a change's jump over those at other times
constexpr double kColour = 0.15;        // correlation of neighbouring nodes' residuals
constexpr double kBends = 400.0;        // statistic of a source that bends the trajectory
constexpr double kContradiction = 1.0;  // of the halves: half of the effect each way

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// What a new effect takes the place of: what it contains, and a source that seemed to be elsewhere.
bool replaces(const Effect& effect, const std::string& name) {
  return contains(effect.description().contains, name) ||
         (effect.name() == "stationary_source" && name == effect.name());
}

// By how many nats one effect may predict worse than another and still be the one to name: the
// simpler of two that explain as much.
double allowance(const Effect& one, const Effect& other, double gain, double other_gain) {
  const auto holds = [](const Effect& a, const Effect& b) {
    return contains(a.description().contains, b.name());
  };
  if (holds(other, one)) return std::max(kDraw, (1.0 - kAsMuch) * other_gain);
  if (holds(one, other)) return -std::max(kDraw, (1.0 - kAsMuch) * gain);
  return one.size() < other.size() ? kDraw : one.size() > other.size() ? -kDraw : 0.0;
}

}  // namespace

Extender::Extender(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                   const DiagnosisOptions& options, Diagnosis& d)
    : recordings_(recordings),
      pipeline_(pipeline),
      given_(options),
      d_(d),
      at_rest_(slow_noise_at_rest(recordings)) {}

double Extender::log10_level() const {
  return std::log10(given_.false_alarm_rate / double(effect_catalogue().size()));
}

Calibration Extender::summary(const Stage& stage) const {
  CalibrationOptions options;
  options.noise = given_.noise;
  options.gravity = given_.gravity;
  Calibration c = summarize(recordings_, stage, options);
  judge(c);
  return c;
}

std::vector<std::shared_ptr<const Effect>> Extender::candidates(const Stage& stage) const {
  std::vector<std::shared_ptr<const Effect>> out = testable_effects(recordings_, stage);
  const auto& accepted = stage.spec().effects;
  std::erase_if(out, [&](const auto& effect) {
    return std::any_of(accepted.begin(), accepted.end(),
                       [&](const auto& a) { return a->name() == effect->name(); });
  });
  return out;
}

Finding Extender::describe(const Option& option, const Stage& stage, double nll,
                           const std::vector<Option>& all, const VectorXd& least_sigma) const {
  const Effect& effect = *option.effect;
  const Calibration c = summary(stage);
  Finding f;
  f.effect = effect.name();
  f.channel = to_string(effect.channel());
  VectorXd theta(effect.size()), sigma(effect.size());
  for (int i = 0; i < effect.size(); ++i) {
    const ActiveEffect::Parameter& p = c.effects.back().parameters[std::size_t(i)];
    theta[i] = p.value;
    sigma[i] = std::max({p.sigma, p.sigma_model, least_sigma[i]});
    if (option.extra.empty()) {
      f.parameters.push_back(
          {effect.description().parameters[std::size_t(i)].name, p.value, sigma[i], p.unit});
    }
  }
  for (const FoundParameter& p : option.extra) f.parameters.push_back(p);
  if (effect.name() == "hard_iron_change") {
    const double dt = 1.0 / recordings_.front()->mag.front().rate_hz();
    const double strength = theta.norm() / std::max(c.noise.mag / std::sqrt(dt), 1e-12);
    const double sigma_t =
        std::hypot(option.sigma_t, dt * std::max(0.5, 4.0 / (strength * strength)));
    f.parameters.push_back({"t0", option.t0, sigma_t, "s"});
    f.parameters.push_back({"t1", option.t1, sigma_t, "s"});
  }
  f.sentence =
      option.extra.empty() ? effect.sentence(theta, sigma) : walk_sentence(option.extra.front());
  f.p_value = std::min(1.0, std::pow(10.0, std::max(-300.0, option.score.log10_p)) *
                                double(effect_catalogue().size()));
  const auto s = std::size_t(effect.channel());
  const double density[2][3] = {
      {stage_->spec().noise.acc, stage_->spec().noise.gyr, stage_->spec().noise.mag},
      {c.noise.acc, c.noise.gyr, c.noise.mag}};
  f.gain = {.heldout_nll_before = nll_,
            .heldout_nll_after = nll,
            .bic_delta = option.score.dof * std::log(3.0 * c.nodes) - option.score.statistic,
            .residual_rms_before =
                stage_->sums().rms(Sensor(s)) * density[0][s] / std::max(density[1][s], 1e-300),
            .residual_rms_after = c.residuals[s].rms};
  f.confusable_with = confusable(option, all);
  return f;
}

struct Extender::Trial {
  Option option;
  Stage stage;
  double nll;

  double total() const { return nll + option.searched; }
  VectorXd parameters() const {
    return effect_parameters(stage.result().values, effect_keys(stage.spec().effects).back());
  }
};

// Is it there in the refitted model, too, under noise as it is?
bool Extender::survives(Option& option, const Stage& stage) const {
  const double level = log10_level();
  const Score w = wald_test(stage, stage.spec().effects.size() - 1,
                            at_rest_.excess(option.effect->channel(), stage.spec().noise));
  if (option.effect->description().random_process) {
    if (w.coloured) {
      const Score& s = option.score;
      option.score.log10_p =
          estimate_random_walk(s.information, s.information * s.theta,
                               option.effect->prior_sigma(recordings_.front()->duration_s()),
                               w.scatter)
              .log10_p;
    }
    return option.score.log10_p < level - (w.coloured ? kCare : 0.0);
  }
  const double penalty =
      option.rank - log10_chi_square_tail(option.score.statistic, option.score.dof);
  option.score.log10_p = std::min(0.0, w.log10_p + std::max(0.0, penalty));
  // The F distribution's far tail is not to be trusted as far as that of white noise.
  if (option.score.log10_p > level - (w.coloured ? kCare : 0.0)) return false;
  if (option.effect->name() == "hard_iron_change") {
    // Few windows have it: their noise is that of the others.
    const double by_others =
        log10_p_by_scatter_of(stage, key::mag_bias, option.score.statistic, option.score.dof);
    option.score.log10_p = std::max(option.score.log10_p, by_others + std::max(0.0, penalty));
    return option.score.log10_p < level && sharpness(option, stage) > kSharp;
  }
  const bool of_time = option.effect->with_terms(1) != nullptr;
  return of_time ||
         contradiction_of_halves(stage, stage.spec().effects.size() - 1) < kContradiction;
}

// An error that lasts must be foretold through whole quarters of the recording: what comes and goes
// with the place where the sensor is held is not. A slow change, where noise is coloured; what
// happens at some time or by chance cannot.
bool Extender::foretells(const Stage& stage) const {
  const Effect& effect = *stage.spec().effects.back();
  if (effect.name() == "hard_iron_change" || effect.description().random_process) return true;
  const bool slow = effect.with_terms(1) != nullptr;
  if (slow && !wald_test(stage, stage.spec().effects.size() - 1).coloured) return true;
  const double quarter = 0.25 * recordings_.front()->duration_s();
  return sum_of(held_out_nll(*stage_, quarter)) - sum_of(held_out_nll(stage, quarter)) > kMinGain;
}

// With a step in the model, does the bias stay the same within the pieces? What changes in many
// ways is no step.
bool Extender::is_all(const Stage& stage) const {
  if (wald_test(stage, stage.spec().effects.size() - 1).coloured) return true;
  const Scan scan(recordings_, stage, {bias_in_windows(change_windows(*recordings_.front()))});
  return scan.scores().front().log10_p > kNoStep;
}

// The times of a change, and the fit with them. Under coloured noise a change is believed where
// neither begins nor ends a rest: there the sensor was put down or taken up, and the field of the
// two places differs. False where no change is left.
bool Extender::find_times(Option& option, Stage& stage) const {
  ModelSpec spec = stage.spec();
  const auto refit = [&](const ChangeTimes& times) {
    spec.effects.back() = make_hard_iron_change_between(times.t0, times.t1);
    return pipeline_.refit_with_same_noise(*stage_, spec, option.start);
  };
  const ChangeTimes found = refined_times(recordings_, stage, {option.t0, option.t1}, refit);
  auto [t0, t1, sigma_s] = found;
  stage = refit(found);
  // With wrong times white noise, too, scatters widely; with the right ones only what is coloured.
  if (wald_test(stage, spec.effects.size() - 1).coloured ||
      stage.sums().lag1[std::size_t(Sensor::kMag)] > kColour) {
    const std::vector<TimeSpan> rests = find_rests(*recordings_.front());
    const auto put_down = [&](double t) {
      return std::any_of(rests.begin(), rests.end(), [&](const TimeSpan& r) {
        return std::abs(t - r.begin_s) < kPutDown || std::abs(t - r.end_s) < kPutDown;
      });
    };
    if (put_down(t0)) t0 = -INFINITY;
    if (put_down(t1)) t1 = INFINITY;
    // From the beginning to the end: nothing changed.
    if (std::isinf(t0) && std::isinf(t1)) return false;
  }
  // A lasting change is on where the bias is the larger: a magnet came or went.
  const Values& values = stage.result().values;
  const Vector3 bias = values.at<Vector3>(key::mag_bias);
  const Vector3 step = effect_parameters(values, effect_keys(spec.effects).back());
  option.start = step;
  if (std::isinf(t1) && std::isfinite(t0) && (bias + step).norm() < bias.norm()) {
    t1 = t0;
    t0 = -INFINITY;
    option.start = -step;
  }
  if (t0 != found.t0 || t1 != found.t1) stage = refit({t0, t1});
  option.effect = spec.effects.back();
  option.t0 = t0;
  option.t1 = t1;
  option.sigma_t = sigma_s;
  // Any moment was as likely before; those within sigma_t are now.
  const double duration = recordings_.front()->duration_s();
  const double sampled = 0.3 / recordings_.front()->mag.front().rate_hz();
  for (const double t : {t0, t1}) {
    if (std::isinf(t)) continue;
    option.searched +=
        std::max(0.0, std::log(duration / (std::sqrt(2.0 * M_PI) * std::max(sampled, sigma_s))));
  }
  return true;
}

// A strong source bends the trajectory of a fit without it, and what that leaves points elsewhere:
// once there is some source in the model, its place is looked for anew.
void Extender::find_source(Option& option, Stage& stage) const {
  for (const LikelySource& source : sources_by_residual(*recordings_.front(), stage)) {
    VectorXd start(6);
    start << source.place, source.moment;
    Stage again = pipeline_.refit_with_same_noise(*stage_, stage.spec(), start);
    if (!again.result().converged() || again.result().cost_final > stage.result().cost_final) {
      continue;
    }
    stage = std::move(again);
    option.start = start;
  }
}

// The model with the option in it, fitted; nothing where it does not hold there.
std::optional<Extender::Trial> Extender::trial(Option option) const {
  ModelSpec spec = stage_->spec();
  std::erase_if(spec.effects, [&](const auto& e) { return replaces(*option.effect, e->name()); });
  spec.effects.push_back(option.effect);
  Stage stage = pipeline_.refit_with_same_noise(*stage_, spec, option.start);
  if (option.effect->name() == "hard_iron_change" && !find_times(option, stage)) {
    return std::nullopt;
  }
  if (option.effect->name() == "stationary_source" && option.score.statistic > kBends) {
    find_source(option, stage);
  }
  if (!stage.result().converged() || !survives(option, stage)) return std::nullopt;
  if (option.effect->description().random_process &&
      rests_contradict_walk(at_rest_, option.extra.front().value)) {
    return std::nullopt;
  }
  if (!foretells(stage)) return std::nullopt;
  if (option.effect->name() == "hard_iron_change" && !is_all(stage)) return std::nullopt;
  const double nll = sum_of(held_out_nll(stage));
  return Trial{std::move(option), std::move(stage), nll};
}

// An effect that contains one already found must add much to it.
bool Extender::enough_beyond(const Option& option, double gain) const {
  return std::none_of(d_.findings.begin(), d_.findings.end(), [&](const Finding& f) {
    return contains(option.effect->description().contains, f.effect) &&
           gain < (1.0 - kAsMuch) * (f.gain.heldout_nll_before - f.gain.heldout_nll_after);
  });
}

std::optional<Finding> Extender::try_options(const std::vector<Option>& options) {
  std::vector<Option> worth;
  std::vector<std::string> names;
  for (const Option& o : options) {
    const std::string& name = o.effect->name();
    if (o.rank > log10_level() || contains(rejected_, name)) continue;
    if (!worth.empty() && o.score.statistic < kWorthTrying * worth.front().score.statistic) {
      continue;
    }
    // The same from several starts counts as one.
    const bool again = contains(names, name);
    const bool known = std::any_of(worth.begin(), worth.end(), [&](const Option& w) {
      return same_class(*w.effect, *o.effect);
    });
    if (known || (!again && int(names.size()) >= kTried)) continue;
    worth.push_back(o);
    if (!again) names.push_back(name);
  }
  std::vector<Trial> trials;
  for (const Option& o : worth) {
    if (std::optional<Trial> t = trial(o)) trials.push_back(*std::move(t));
  }
  const Trial* best = nullptr;
  for (const Trial& t : trials) {
    if (best == nullptr ||
        t.total() < best->total() + allowance(*t.option.effect, *best->option.effect,
                                              nll_ - t.total(), nll_ - best->total())) {
      best = &t;
    }
  }
  if (best != nullptr && nll_ - best->total() > kMinGain &&
      enough_beyond(best->option, nll_ - best->total())) {
    Stage stage = pipeline_.refit(best->stage, best->stage.spec());
    double nll = sum_of(held_out_nll(stage));
    if (!stage.result().converged() || nll > best->nll + kMinGain) {  // lost its way
      stage = best->stage;
      nll = best->nll;
    }
    if (nll_ - nll > kMinGain) {
      // The same effect may be about as likely with other parameters.
      VectorXd apart = VectorXd::Zero(best->option.effect->size());
      double others = std::exp(std::min(700.0, best->total() - nll_));  // nothing
      for (const Trial& t : trials) {
        const bool richer =
            allowance(*best->option.effect, *t.option.effect, 0.0, 1.0) > kDraw - 1e-9;
        const bool other = t.option.effect->name() != best->option.effect->name();
        if (other && !richer) others += std::exp(std::min(700.0, best->total() - t.total()));
        if (!other && t.total() - best->total() < kAsLikely) {
          apart = apart.cwiseMax((t.parameters() - best->parameters()).cwiseAbs());
        }
      }
      Finding f = describe(best->option, stage, nll, options, apart);
      f.probability = 1.0 / (1.0 + others);
      stage_ = stage;
      nll_ = nll;
      std::erase_if(d_.findings, [&](const Finding& old) {
        if (!replaces(*best->option.effect, old.effect)) return false;
        f.gain.heldout_nll_before =
            std::max(f.gain.heldout_nll_before, old.gain.heldout_nll_before);
        return true;
      });
      return f;
    }
  }
  rejected_.insert(rejected_.end(), names.begin(), names.end());
  return std::nullopt;
}

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
      const Stage without = pipeline_.refit_with_same_noise(*stage_, spec);
      const double nll = sum_of(held_out_nll(without));
      if (without.result().converged() && nll - nll_ < kMinGain) {
        stage_ = without;
        nll_ = nll;
        d_.findings.erase(finding);
        continue;
      }
    }
    ++e;
  }
}

void Extender::replace(const Stage& stage) {
  stage_ = stage;
  nll_ = sum_of(held_out_nll(stage));
}

void Extender::extend(const Stage& from) {
  stage_ = from;
  nll_ = sum_of(held_out_nll(from));
  rejected_.clear();
  for (bool first = true; int(d_.findings.size()) < given_.max_findings; first = false) {
    const std::vector<Option> options = scan_options(recordings_, *stage_, candidates(*stage_));
    if (first) d_.scan = scan_entries(options, recordings_, *stage_, log10_level());
    const std::size_t rejected = rejected_.size();
    std::optional<Finding> finding = try_options(options);
    if (finding) {
      d_.findings.push_back(*std::move(finding));
      rejected_.clear();  // beside it another may hold
      prune();
    } else if (rejected_.size() == rejected) {
      break;
    }
  }
}

}  // namespace magimu
