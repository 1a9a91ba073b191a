// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/extender.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "calibration/fit/summary.h"
#include "calibration/scan/testable.h"
#include "diagnosis/held/held_out_nll.h"
#include "diagnosis/noise/noise_tests.h"
#include "diagnosis/search/finding_text.h"
#include "diagnosis/search/option.h"
#include "diagnosis/search/scan_options.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr double kWorthTrying = 0.4;  // of the best candidate's statistic
// The same of a change of gains: each trial takes several fits, and half a window off its true time
// it still has most of its statistic.
constexpr double kChangeWorthTrying = 0.7;
constexpr double kAsLikely = 4.0;  // nats within which a second answer counts as one

}  // namespace

Extender::Extender(const std::vector<const Recording*>& recordings,
                   const std::vector<const Recording*>& whole, const Pipeline& pipeline,
                   const DiagnosisOptions& options, Diagnosis& d)
    : recordings_(recordings),
      whole_(whole),
      pipeline_(pipeline),
      given_(options),
      d_(d),
      at_rest_(slow_noise_at_rest(whole)) {
  for (const Recording* r : whole) step_uT_ = std::max(step_uT_, coarse_step(r->mag.front()));
}

double Extender::log10_level() const {
  return std::log10(given_.false_alarm_rate / double(count_looked_for()));
}

Calibration Extender::summary(const Stage& stage) const {
  CalibrationOptions options;
  options.noise = given_.noise;
  options.gravity = given_.gravity;
  return summarize(recordings_, stage, options);
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

void Extender::add_times(const ChangeSpan& span, const std::array<double, 2>& sigma_t,
                         Finding& f) const {
  const double half = 0.5 / recordings_.front()->mag.front().rate_hz();
  f.parameters.push_back({"t0", span.begin.t, std::hypot(sigma_t[0], half), "s"});
  f.parameters.push_back({"t1", span.end.t, std::hypot(sigma_t[1], half), "s"});
  // Of several recordings, which: the first is 1.
  const bool several = field_count(recordings_) > 1;
  for (const auto& [name, at] :
       {std::pair("recording_of_t0", span.begin), std::pair("recording_of_t1", span.end)}) {
    if (several && at.finite()) f.parameters.push_back({name, double(at.recording + 1), 0.0, "1"});
  }
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
  if (is_change(effect.name())) add_times(option.span, option.sigma_t, f);
  f.sentence =
      option.extra.empty() ? effect.sentence(theta, sigma) : walk_sentence(option.extra.front());
  f.p_value = std::min(
      1.0, std::pow(10.0, std::max(-300.0, option.score.log10_p)) * double(count_looked_for()));
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

// An effect that contains one already found must add much to it.
bool Extender::enough_beyond(const Option& option, double gain) const {
  return std::none_of(d_.findings.begin(), d_.findings.end(), [&](const Finding& f) {
    return contains(*option.effect, f.effect) &&
           gain < (1.0 - kAsMuch) * (f.gain.heldout_nll_before - f.gain.heldout_nll_after);
  });
}

// The best of those that may hold, a few names.
std::vector<Option> Extender::worth_trying(const std::vector<Option>& options) const {
  std::vector<Option> worth;
  std::vector<std::string> names;
  for (const Option& o : options) {
    const std::string& name = o.effect->name();
    if (o.rank > log10_level() || among(rejected_, name)) continue;
    const bool matrix = is_change(name) && forms_of_change(name).front() != ChangeForm::kOffset;
    const double least = matrix ? kChangeWorthTrying : kWorthTrying;
    if (!worth.empty() && o.score.statistic < least * worth.front().score.statistic) continue;
    // The same from several starts counts as one.
    const bool again = among(names, name);
    const bool known = std::any_of(worth.begin(), worth.end(), [&](const Option& w) {
      return same_class(*w.effect, *o.effect);
    });
    // What begins, ends or drifts explains a little of any slow misfit: it takes no other's place.
    const bool counts = lasts(*o.effect);
    if (known || (!again && counts && int(names.size()) >= kTried)) continue;
    worth.push_back(o);
    if (!again && counts) names.push_back(name);
  }
  return worth;
}

// The most likely; null if there is none.
const Extender::Trial* Extender::best_of(const std::vector<Trial>& trials) {
  const Trial* best = nullptr;
  for (const Trial& t : trials) {
    if (best == nullptr || t.gain > best->gain - allowance(*t.option.effect, *best->option.effect,
                                                           t.gain, best->gain)) {
      best = &t;
    }
  }
  return best;
}

std::optional<Finding> Extender::try_options(const std::vector<Option>& options) {
  const std::vector<Option> worth = worth_trying(options);
  const std::vector<Trial> found = trials(worth);
  const Trial* best = best_of(found);
  if (best != nullptr && enough_beyond(best->option, best->left_out - best->option.searched)) {
    Stage stage = best->stage;
    double nll = best->nll;
    attempt([&] {
      const Stage anew = pipeline_.refit(best->stage, best->stage.spec());
      const double its = sum_of(held_out_nll(anew));
      const bool lost_its_way = !anew.result().converged() || !(its <= best->nll + kMinGain);
      if (lost_its_way) return false;
      stage = anew;
      nll = its;
      return true;
    });
    if (std::max(nll_ - nll, best->left_out) > kMinGain) {
      // The same effect may be about as likely with other parameters.
      VectorXd apart = VectorXd::Zero(best->option.effect->size());
      double others = std::exp(std::min(700.0, -best->alone));  // nothing
      for (const Trial& t : found) {
        const bool richer =
            allowance(*best->option.effect, *t.option.effect, 0.0, 1.0) > kDraw - 1e-9;
        const bool other = t.option.effect->name() != best->option.effect->name();
        if (other && !richer) others += std::exp(std::min(700.0, t.gain - best->gain));
        if (!other && best->gain - t.gain < kAsLikely) {
          apart = apart.cwiseMax((t.parameters() - best->parameters()).cwiseAbs());
        }
      }
      Finding f = describe(best->option, stage, nll, options, apart);
      f.probability = 1.0 / (1.0 + others);
      entered_[f.effect] = {apart, best->option.searched};
      if (nll_ - nll < kMinGain) {  // what lasts shows in whole quarters
        f.gain.heldout_nll_after = sum_of(held_out_nll(stage, quarter_s()));
        f.gain.heldout_nll_before = f.gain.heldout_nll_after + best->left_out;
      }
      take(stage, nll);
      std::erase_if(d_.findings, [&](const Finding& old) {
        if (!replaces(*best->option.effect, old.effect)) return false;
        f.gain.heldout_nll_before =
            std::max(f.gain.heldout_nll_before, old.gain.heldout_nll_before);
        return true;
      });
      return f;
    }
  }
  for (const Option& o : worth) {
    if (!among(rejected_, o.effect->name())) rejected_.push_back(o.effect->name());
  }
  return std::nullopt;
}

void Extender::take(const Stage& stage, double nll) {
  stage_ = stage;
  nll_ = nll;
  refitted_.reset();
  processes_.clear();
  explain_most_.clear();
}

void Extender::replace(const Stage& stage) { take(stage, sum_of(held_out_nll(stage))); }

void Extender::extend(const Stage& from) {
  refits_spent_ = false;
  refused_changes_.clear();
  may_have_changed_.clear();
  take(from, sum_of(held_out_nll(from)));
  rejected_.clear();
  expelled_.clear();
  if (given_.noise) {
    in_samples_ = excess_of_samples(recordings_, from, *given_.noise);
  }
  // A model that cannot be scanned (its numbers fail) has no candidates.
  const auto scanned = [&] {
    return attempt([&] { return scan_options(recordings_, *stage_, candidates(*stage_)); })
        .value_or(std::vector<Option>{});
  };
  std::vector<Option> options = scan_options(recordings_, *stage_, candidates(*stage_));
  // Of a model that has been extended before, the scan tells no more of what was found in it.
  if (d_.scan.empty()) d_.scan = scan_entries(options, recordings_, *stage_, log10_level());
  bool to_refine = false;  // a cause has entered since changes were refined
  int entries = 0;
  // Pairs, too, may leave again: twice as many entries are the end in any case.
  while (int(d_.findings.size()) < given_.max_findings && entries < 2 * given_.max_findings) {
    const std::size_t rejected = rejected_.size();
    bool now = true;  // changes are refined: a pair or a change has entered
    std::string entered;
    const auto named = [&] {
      return std::size_t(std::ranges::count(d_.findings, entered, &Finding::effect));
    };
    std::size_t before = 0, of_this_name = 0;
    if (std::optional<Finding> finding =
            attempt([&] { return try_options(options); }).value_or(std::nullopt)) {
      now = is_change(finding->effect);
      entered = finding->effect;
      of_this_name = named();
      before = d_.findings.size();
      d_.findings.push_back(*std::move(finding));
    } else if (rejected_.size() > rejected) {
      continue;  // with the next best
    } else if (!try_pairs(options)) {
      break;
    }
    ++entries;
    prune();
    to_refine = !now;
    if (now) {
      join_changes();
      refine_changes();
    }
    // What enters and is not needed beside what was there before would enter for ever.
    if (!entered.empty() && d_.findings.size() <= before && named() <= of_this_name) {
      expelled_.push_back(entered);
    }
    rejected_ = expelled_;  // beside it another may hold
    options = scanned();
  }
  if (to_refine) refine_changes();
  reconsider();
  estimate_walk_anew();
}

}  // namespace magimu
