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
#include "diagnosis/doubts.h"
#include "diagnosis/finding_text.h"
#include "diagnosis/held_out_nll.h"
#include "diagnosis/option.h"
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
constexpr double kAsMuch = 0.85;        // of the gain, for a nested cause to be the one named
constexpr double kNoStep = -6.0;        // log10 of the probability of what is left beside a step
constexpr double kSharp = 4.0;          // a change's jump over those at other times
constexpr double kContradiction = 1.0;  // of the halves: half of the effect each way

// Columns first .. first + count - 1 of all.
MatrixXd selection(Eigen::Index all, int first, int count) {
  MatrixXd C = MatrixXd::Zero(all, count);
  C.middleRows(first, count).setIdentity();
  return C;
}

// Is it there in the refitted model, too, under noise as it is?
bool survives(Option& option, const Stage& stage, double level) {
  const Score w = wald_test(stage, stage.spec().effects.size() - 1);
  if (option.effect->description().random_process) {
    option.score.log10_p = log10_chi_square_tail(
        option.score.statistic / (w.scatter > kColoured ? w.scatter : 1.0), 1.0);
    return option.score.log10_p < level;
  }
  const double penalty =
      option.rank - log10_chi_square_tail(option.score.statistic, option.score.dof);
  option.score.log10_p = std::min(0.0, w.log10_p + std::max(0.0, penalty));
  // The F distribution's far tail is not to be trusted as far as that of white noise.
  if (option.score.log10_p > level - (w.scatter > kColoured ? kCare : 0.0)) return false;
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

// By how many nats one effect may predict worse than another and still be the one to name: the
// simpler of two that explain as much.
double allowance(const Effect& one, const Effect& other, double gain, double other_gain) {
  const auto contains = [](const Effect& a, const Effect& b) {
    const auto& within = a.description().contains;
    return std::find(within.begin(), within.end(), b.name()) != within.end();
  };
  if (contains(other, one)) return std::max(kDraw, (1.0 - kAsMuch) * other_gain);
  if (contains(one, other)) return -std::max(kDraw, (1.0 - kAsMuch) * gain);
  return one.size() < other.size() ? kDraw : one.size() > other.size() ? -kDraw : 0.0;
}

int change_windows(const Recording& r) {
  return std::clamp(int(r.duration_s() / kChangeWindow), 2, kMaxChangeWindows);
}

}  // namespace

Extender::Extender(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                   const DiagnosisOptions& options, Diagnosis& d)
    : recordings_(recordings), pipeline_(pipeline), given_(options), d_(d) {}

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

std::vector<Option> Extender::test_all(const Stage& stage,
                                       const std::vector<std::shared_ptr<const Effect>>& effects) {
  std::vector<std::shared_ptr<const Effect>> all = effects;
  const std::size_t plain = all.size();
  const bool single = recordings_.size() == 1;
  const int windows = change_windows(*recordings_.front());
  if (single) all.push_back(bias_in_windows(windows));
  std::vector<Vector3> places;
  if (single && recordings_.front()->pos)
    places = likely_source_places(*recordings_.front(), stage);
  for (const Vector3& place : places) all.push_back(make_stationary_source_at(place));
  const Scan scan(recordings_, stage, all);

  std::vector<Option> out;
  for (std::size_t i = 0; i < plain; ++i) {
    Option option{.effect = all[i], .score = scan.scores()[i]};
    const Eigen::Index n = scan.information().rows();
    if (all[i]->name() == "gyro_bias_drift") {
      const VectorXd unit = all[i]->prior_sigma(recordings_.front()->duration_s());
      const Score& s = scan.scores()[i];
      const RandomWalk walk = estimate_random_walk(
          s.information, scan.score().segment(scan.first(i), unit.size()), unit);
      option.score.statistic = walk.likelihood_ratio;
      option.score.dof = 1;
      // Coloured noise makes a walk look larger: what its scatter explains is taken away.
      option.rank = walk.log10_p;
      option.score.log10_p = log10_chi_square_tail(
          walk.likelihood_ratio / std::max(1.0, s.scatter > 1.25 ? s.scatter : 1.0), 1.0);
      option.effect = make_gyro_bias_walk(all[i]->size() / 3, std::max(walk.density, 1e-9));
      option.extra = {{"q", walk.density, walk.sigma, "rad/s per sqrt(s)"}};
    } else if (all[i]->with_terms(1)) {
      double best = 1.0;
      for (int terms = 1; 3 * terms <= all[i]->size(); ++terms) {
        const Score s = scan.combined(selection(n, scan.first(i), 3 * terms));
        const double rank = log10_chi_square_tail(s.statistic, s.dof);
        if (terms > 1 && rank >= best) continue;
        best = rank;
        option.score = s;
        option.effect = all[i]->with_terms(terms);
        option.rank = rank;
      }
      option.score.log10_p = std::min(0.0, option.score.log10_p + std::log10(3.0));
    } else {
      option.rank = log10_chi_square_tail(option.score.statistic, option.score.dof);
    }
    out.push_back(option);
  }
  if (single) {
    const std::vector<double>& t = recordings_.front()->gyr.t;
    const BiasChange change = find_bias_change(scan, plain, windows, t.front(), t.back());
    Option option{.effect = make_hard_iron_change_between(change.t0, change.t1),
                  .score = change.score,
                  .start = change.score.theta,
                  .t0 = change.t0,
                  .t1 = change.t1};
    option.rank = log10_chi_square_tail(change.score.statistic, change.score.dof) + change.log10_p -
                  change.score.log10_p;
    option.score.log10_p = change.log10_p;
    if (change.score.dof > 0) out.push_back(option);
  }
  for (std::size_t p = 0; p < places.size(); ++p) {
    const Score& s = scan.scores()[plain + 1 + p];
    Option option{.effect = find_effect("stationary_source"), .score = s};
    option.start.resize(6);
    option.start << places[p], s.theta;
    // A place is three parameters more, searched for among hundreds.
    option.score.dof += 3;
    option.rank = log10_chi_square_tail(s.statistic, option.score.dof);
    option.score.log10_p = std::min(0.0, std::max(s.log10_p, option.rank) + 1.0);
    out.push_back(option);
  }
  // Of two that are the same to first order, the offset is the simpler.
  for (Option& o : out) {
    if (o.effect->name() == "mag_lag") o.rank *= 1.0 - 1e-6;
  }
  std::sort(out.begin(), out.end(),
            [](const Option& a, const Option& b) { return a.rank < b.rank; });
  return out;
}

// The times of a change, found to the sample in the residuals of a fit that has it. Under coloured
// noise a change is believed where neither begins nor ends a rest: there the sensor was put down or
// taken up, and the field of the two places differs.
Option Extender::with_refined_times(const Option& option, const Stage& stage) const {
  const Recording& recording = *recordings_.front();
  Option out = option;
  const double width = 1.5 * recording.duration_s() / change_windows(recording);
  VectorXd step;
  const VectorSeries residual = residual_without_last(stage, step);
  if (std::isfinite(option.t0)) out.t0 = refine_time(residual, step, option.t0, width, true);
  if (std::isfinite(option.t1)) out.t1 = refine_time(residual, step, option.t1, width, false);
  if (wald_test(stage, stage.spec().effects.size() - 1).scatter > kColoured) {
    const std::vector<TimeSpan> rests = find_rests(recording);
    const auto put_down = [&](double t) {
      return std::any_of(rests.begin(), rests.end(), [&](const TimeSpan& r) {
        return std::abs(t - r.begin_s) < kPutDown || std::abs(t - r.end_s) < kPutDown;
      });
    };
    if (put_down(out.t0)) out.t0 = -INFINITY;
    if (put_down(out.t1)) out.t1 = INFINITY;
    // From the beginning to the end: nothing changed.
    if (std::isinf(out.t0) && std::isinf(out.t1)) return out;
  }
  // A lasting change is on where the bias is the larger: a magnet came or went.
  const Vector3 bias = stage.result().values.at<Vector3>(key::mag_bias);
  if (std::isinf(out.t1) && std::isfinite(out.t0) && Vector3(bias + step).norm() < bias.norm()) {
    out.t1 = out.t0;
    out.t0 = -INFINITY;
    step = -step;
  }
  out.effect = make_hard_iron_change_between(out.t0, out.t1);
  out.start = step;
  return out;
}

Finding Extender::describe(const Option& option, const Stage& stage, double nll,
                           const std::vector<Option>& all) const {
  const Effect& effect = *option.effect;
  const Calibration c = summary(stage);
  Finding f;
  f.effect = effect.name();
  f.channel = to_string(effect.channel());
  VectorXd theta(effect.size()), sigma(effect.size());
  for (int i = 0; i < effect.size(); ++i) {
    const ActiveEffect::Parameter& p = c.effects.back().parameters[std::size_t(i)];
    theta[i] = p.value;
    sigma[i] = std::max(p.sigma, p.sigma_model);
    if (option.extra.empty()) {
      f.parameters.push_back(
          {effect.description().parameters[std::size_t(i)].name, p.value, sigma[i], p.unit});
    }
  }
  for (const FoundParameter& p : option.extra) f.parameters.push_back(p);
  if (effect.name() == "hard_iron_change") {
    const double dt = 1.0 / recordings_.front()->mag.front().rate_hz();
    const double strength = theta.norm() / std::max(c.noise.mag / std::sqrt(dt), 1e-12);
    const double sigma_t = dt * std::max(0.5, 4.0 / (strength * strength));
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
};

// A slow change that is believed under coloured noise must be foretold through whole quarters of
// the recording: what comes and goes with the place where the sensor is held is not.
bool Extender::foretells(const Stage& stage) const {
  if (wald_test(stage, stage.spec().effects.size() - 1).scatter < kColoured) return true;
  const double quarter = 0.25 * recordings_.front()->duration_s();
  return sum_of(held_out_nll(*stage_, quarter)) - sum_of(held_out_nll(stage, quarter)) > kMinGain;
}

// With a step in the model, does the bias stay the same within the pieces? What changes in many
// ways is no step.
bool Extender::is_all(const Stage& stage) const {
  if (wald_test(stage, stage.spec().effects.size() - 1).scatter > kColoured) return true;
  const Scan scan(recordings_, stage, {bias_in_windows(change_windows(*recordings_.front()))});
  return scan.scores().front().log10_p > kNoStep;
}

// The model with the option in it, fitted; nothing where it does not hold there.
std::optional<Extender::Trial> Extender::trial(Option option) const {
  ModelSpec spec = stage_->spec();
  // What the new effect contains is no longer needed beside it.
  std::erase_if(spec.effects, [&](const auto& e) {
    const auto& within = option.effect->description().contains;
    return std::find(within.begin(), within.end(), e->name()) != within.end();
  });
  spec.effects.push_back(option.effect);
  Stage stage = pipeline_.refit_with_same_noise(*stage_, spec, option.start);
  if (option.effect->name() == "hard_iron_change") {
    option = with_refined_times(option, stage);
    if (std::isinf(option.t0) && std::isinf(option.t1)) return std::nullopt;
    spec.effects.back() = option.effect;
    stage = pipeline_.refit_with_same_noise(*stage_, spec, option.start);
  }
  if (!stage.result().converged() || !survives(option, stage, log10_level())) return std::nullopt;
  if (option.effect->with_terms(1) && !foretells(stage)) return std::nullopt;
  if (option.effect->name() == "hard_iron_change" && !is_all(stage)) return std::nullopt;
  const double nll = sum_of(held_out_nll(stage));
  return Trial{std::move(option), std::move(stage), nll};
}

// An effect that contains one already found must add much to it.
bool Extender::enough_beyond(const Option& option, double gain) const {
  const auto& within = option.effect->description().contains;
  return std::none_of(d_.findings.begin(), d_.findings.end(), [&](const Finding& f) {
    return std::find(within.begin(), within.end(), f.effect) != within.end() &&
           gain < (1.0 - kAsMuch) * (f.gain.heldout_nll_before - f.gain.heldout_nll_after);
  });
}

std::optional<Finding> Extender::try_options(const std::vector<Option>& options) {
  std::vector<Option> worth;
  for (const Option& o : options) {
    const std::string& name = o.effect->name();
    if (o.rank > log10_level() || int(worth.size()) >= kTried) continue;
    if (std::find(rejected_.begin(), rejected_.end(), name) != rejected_.end()) continue;
    const bool known = std::any_of(worth.begin(), worth.end(), [&](const Option& w) {
      return w.effect->name() == name || same_class(*w.effect, *o.effect);
    });
    if (known) continue;
    if (!worth.empty() && o.score.statistic < kWorthTrying * worth.front().score.statistic) {
      continue;
    }
    worth.push_back(o);
  }
  std::vector<Trial> trials;
  for (const Option& o : worth) {
    if (std::optional<Trial> t = trial(o)) trials.push_back(*std::move(t));
  }
  const Trial* best = nullptr;
  for (const Trial& t : trials) {
    if (best == nullptr || t.nll < best->nll + allowance(*t.option.effect, *best->option.effect,
                                                         nll_ - t.nll, nll_ - best->nll)) {
      best = &t;
    }
  }
  if (best != nullptr && nll_ - best->nll > kMinGain &&
      enough_beyond(best->option, nll_ - best->nll)) {
    const Stage stage = pipeline_.refit(best->stage, best->stage.spec());
    const double nll = sum_of(held_out_nll(stage));
    if (stage.result().converged() && nll_ - nll > kMinGain) {
      Finding f = describe(best->option, stage, nll, options);
      double others = std::exp(std::min(700.0, best->nll - nll_));  // nothing
      for (const Trial& t : trials) {
        const bool richer =
            allowance(*best->option.effect, *t.option.effect, 0.0, 1.0) > kDraw - 1e-9;
        if (&t != best && !richer) others += std::exp(std::min(700.0, best->nll - t.nll));
      }
      f.probability = 1.0 / (1.0 + others);
      stage_ = stage;
      nll_ = nll;
      std::erase_if(d_.findings, [&](const Finding& old) {
        const auto& within = best->option.effect->description().contains;
        return std::find(within.begin(), within.end(), old.effect) != within.end();
      });
      return f;
    }
  }
  for (const Option& o : worth) rejected_.push_back(o.effect->name());
  return std::nullopt;
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
    const std::vector<Option> options = test_all(*stage_, candidates(*stage_));
    if (first) d_.scan = scan_entries(options, recordings_, *stage_, log10_level());
    const std::size_t rejected = rejected_.size();
    std::optional<Finding> finding = try_options(options);
    if (finding) {
      d_.findings.push_back(*std::move(finding));
    } else if (rejected_.size() == rejected) {
      break;
    }
  }
}

}  // namespace magimu
