// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/noise_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "diagnosis/conclude/departures.h"
#include "diagnosis/conclude/unexplained.h"
#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/noise_causes.h"
#include "diagnosis/noise/noise_series.h"
#include "diagnosis/noise/noise_tests.h"
#include "diagnosis/noise/own_clock.h"
#include "diagnosis/noise/sample_residuals.h"
#include "diagnosis/noise/thinned.h"
#include "diagnosis/search/finding_text.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"
#include "recording/checks/quality.h"
#include "recording/checks/rounding.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

struct NoiseOf {
  std::vector<SampleResiduals> residuals;
  std::vector<NoiseTest> tests, causes;
};

// Tests of noise-like causes on all channels, which share the level.
constexpr double kTests = 12.0;
constexpr double kMinTails = 2.5;      // K of outliers
constexpr double kStrongLine = 1e-12;  // p
constexpr double kBelowLimit = 4.0;    // standard deviations of a sample
// A correlation without a name is told at the level of one of about so many statistics
// (departures.h).
constexpr int kStatisticsOfOne = 500;

Finding to_finding(const NoiseTest& t) {
  Finding f;
  f.effect = t.effect;
  f.channel = to_string(t.channel);
  f.sentence = t.sentence;
  f.parameters = t.parameters;
  f.p_value = std::min(1.0, kTests * t.p_value);
  f.probability = 1.0 - f.p_value;
  f.gain = {.heldout_nll_before = t.nll_before,
            .heldout_nll_after = t.nll_after,
            .bic_delta = 2.0 * (t.nll_after - t.nll_before),
            .residual_rms_before = 1.0,
            .residual_rms_after = 1.0};
  return f;
}

// The correlation or the scale that would have been found; empty where no such number is known.
std::string detectable(const NoiseTest& t, double level) {
  if (t.parameters.empty()) return "";
  const double least = detectable_size(t.dof, std::log10(level)) * t.parameters.front().sigma;
  if (t.effect == "correlated_noise") return fmt::format("a correlation of {:.1g}", least);
  if (t.effect == "noise_scale") {
    return fmt::format("{:.3g} times as large as given", 1.0 + kDensityKnownTo + least);
  }
  return "";
}

ScanEntry to_entry(const NoiseTest& t, double level) {
  ScanEntry e{.effect = t.effect, .channel = to_string(t.channel)};
  for (const FoundParameter& p : t.parameters) e.parameters.push_back(p.name);
  e.statistic = t.statistic;
  e.dof = t.dof;
  e.p_value = t.p_value;
  e.significant = t.untested.empty() && t.p_value < level;
  e.needs = t.untested;
  if (e.needs.empty() && !e.significant) e.detectable = detectable(t, level);
  return e;
}

// What coloured noise may imitate: a weak line, tails that are hardly heavier.
bool imitated_by_colour(const NoiseTest& t, const std::vector<NoiseTest>& all) {
  const bool coloured = std::any_of(all.begin(), all.end(), [&](const NoiseTest& o) {
    return o.effect == "correlated_noise" && o.channel == t.channel;
  });
  if (!coloured) return false;
  if (t.effect == "outliers") return t.parameters.size() > 1 && t.parameters[1].value < kMinTails;
  return t.effect == "mains_interference" && t.p_value > kStrongLine;
}

std::optional<OwnClock> strongest_clock(const std::vector<NoiseOf>& all, double level) {
  std::optional<OwnClock> out;
  double before = 0.0;
  for (const NoiseOf& of : all) {
    for (const SampleResiduals& samples : of.residuals) {
      if (samples.channel != Sensor::kMag) continue;
      const auto clock = find_own_clock(samples, level / double(all.size()));
      if (!clock) continue;
      before += clock->nll_before;
      if (!out || clock->p_value < out->p_value) out = clock;
    }
  }
  if (!out) return out;
  out->nll_before = before;
  out->p_value = std::min(1.0, out->p_value * double(all.size()));
  return out;
}

ScanEntry entry_of_clock(const std::optional<OwnClock>& clock, double level) {
  if (clock) return to_entry(own_clock_test(*clock), level);
  return {.effect = "mag_own_clock",
          .channel = to_string(Sensor::kMag),
          .parameters = {"T", "p"},
          .dof = 2};
}

// Blows to a sensor that only turns: neither outliers, which come alone, nor the colour or the size
// of its noise. The hand's motion is no part of the model there.
bool shows_blows(const SampleResiduals& acc, const std::vector<NoiseTest>& all) {
  return !acc.high_passed && std::ranges::any_of(all, [](const NoiseTest& t) {
    return t.in_bursts && t.channel == Sensor::kAcc && t.parameters[1].value > kMinTails;
  });
}

bool has_clock(const Stage& stage) {
  return std::ranges::any_of(stage.spec().effects,
                             [](const auto& e) { return e->name() == "mag_own_clock"; });
}

// What so many parameters more explain by chance, once in 1 / level times.
bool is_chance(double nats, double level, int parameters = 1) {
  return chi_square_tail(2.0 * std::max(0.0, nats), parameters) > level;
}

// Whether it is the samples' mean age: half a period.
bool is_mean_age(const Finding& lag, const OwnClock& clock, double level) {
  const FoundParameter& tau = lag.parameters.front();
  const double off = (tau.value - 0.5 * clock.period_s) / tau.sigma;
  return clock.held && is_chance(0.5 * off * off, level);
}

// Where samples are thinned for the fits, their ages are not those of single samples.
bool has_ages_of_samples(const std::vector<const Recording*>& recordings) {
  return recordings.size() == 1 && !is_thinned(recordings.front()->mag.front());
}

ModelSpec with_clock(const Recording& recording, ModelSpec spec, const OwnClock& clock) {
  // Of the standard deviations that single samples give: the prior in the fit. So the clock stays
  // where the samples have it; the fit sees means of samples, which know less of it. Where the
  // attitudes have taken a part of it the samples know it less well.
  constexpr double kOfPrior = 1.0 / 30.0;
  const double of_prior = clock.needed_nats > 0.0 ? 1.0 : kOfPrior;
  const std::vector<double>& t = recording.mag.front().t;
  spec.effects.push_back(
      make_own_clock_at(clock.period_s, clock.share, 0.5 * (t.front() + t.back()),
                        of_prior * clock.period_sigma_s, of_prior * clock.share_sigma));
  return spec;
}

// A clock in the model, and by how many nats the readings are more probable with it.
struct FittedClock {
  std::optional<Stage> stage;
  double gain = 0.0;
};
FittedClock fit_with_clock(const Recording& recording, const Pipeline& pipeline,
                           const Stage& without, const Stage& start, const OwnClock& clock) {
  FittedClock out;
  attempt([&] {
    Stage stage =
        pipeline.refit_with_same_noise(start, with_clock(recording, without.spec(), clock));
    if (!stage.result().converged()) return false;
    out.gain = without.result().cost_final - stage.result().cost_final;
    out.stage = std::move(stage);
    return true;
  });
  return out;
}

// Of the clocks that the samples do not tell apart, the one that a fit is the better with. (The
// attitudes have taken a part of a slow one's ages; with the clock in the model they have not, and
// the samples tell its period and share once more.) Nothing where what is left repeats itself with
// its period all the same: a lag that is no clock's.
std::optional<OwnClock> clock_of_fits(const Recording& recording, const Pipeline& pipeline,
                                      const DiagnosisOptions& options, const Stage& without,
                                      const NoiseOf& of, double level) {
  // Of what the sawtooth explains, in ages that are any function of its phase: a square wave of
  // ages has 0.33, a sine 0.6.
  constexpr double kMostBeyond = 0.25;
  std::vector<OwnClock> possible;
  for (const SampleResiduals& samples : of.residuals) {
    if (samples.channel != Sensor::kMag) continue;
    std::ranges::copy(find_own_clocks(samples, level), std::back_inserter(possible));
  }
  if (possible.empty()) return std::nullopt;
  std::optional<OwnClock> by_itself;  // as the samples show it
  if (possible.front().needed_nats == 0.0) by_itself = possible.front();
  if (by_itself && possible.size() == 1) return by_itself;
  FittedClock best;
  OwnClock out;
  for (const OwnClock& clock : possible) {
    FittedClock fitted = fit_with_clock(recording, pipeline, without, without, clock);
    if (!fitted.stage || fitted.gain <= best.gain) continue;
    best = std::move(fitted);
    out = clock;
  }
  if (!best.stage || out.needed_nats == 0.0) return by_itself;
  const auto samples_of = [&](const Stage& stage) {
    std::vector<SampleResiduals> all =
        sample_residuals(recording, stage, 0, pipeline.rest_noise(), options.noise.has_value());
    return *std::ranges::find(all, Sensor::kMag, &SampleResiduals::channel);
  };
  const double needed = out.needed_nats;
  const OwnClock told = told_anew(out, samples_of(*best.stage));
  if (FittedClock again = fit_with_clock(recording, pipeline, without, *best.stage, told);
      again.stage && again.gain > best.gain) {
    best = std::move(again);
    out = told;
  }
  if (!best.stage || best.gain < needed) return by_itself;
  if (pattern_left(out, samples_of(*best.stage)) > kMostBeyond * best.gain) return by_itself;
  out.nll_before = best.gain;
  return out;
}

// The model with the clock in it. A lag that stood for the samples' mean age leaves. Where samples
// are thinned the clock stays a finding in the samples, and a lag of their mean age is its part in
// the model.
void extend_by_clock(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                     Extender& extender, const OwnClock& clock, double level, Diagnosis& d) {
  if (!has_ages_of_samples(recordings)) {
    std::erase_if(d.findings, [&](const Finding& f) {
      return is_lag(f.effect) && is_mean_age(f, clock, level);
    });
    return;
  }
  ModelSpec spec = with_clock(*recordings.front(), extender.stage().spec(), clock);
  attempt([&] {
    Stage best = pipeline.refit_with_same_noise(extender.stage(), spec);
    if (!best.result().converged()) return false;
    const auto lag =
        std::ranges::find_if(spec.effects, [](const auto& e) { return is_lag(e->name()); });
    if (lag != spec.effects.end()) {
      const std::string name = (*lag)->name();
      spec.effects.erase(lag);
      const Stage less = pipeline.refit_with_same_noise(best, spec);
      if (less.result().converged() &&
          is_chance(less.result().cost_final - best.result().cost_final, level)) {
        std::erase_if(d.findings, [&](const Finding& f) { return f.effect == name; });
        best = less;
      }
    }
    extender.replace(best);
    // The noise was estimated with the clock's errors in it.
    const Stage quiet = pipeline.refit(best, best.spec());
    if (quiet.result().converged()) extender.replace(quiet);
    return true;
  });
}

// Causes that were named for what the clock does explain nothing beside it.
void withdraw_beside_clock(Extender& extender, double level, Diagnosis& d) {
  for (std::size_t e = 0; e < extender.stage().spec().effects.size();) {
    const Effect& effect = *extender.stage().spec().effects[e];
    const auto finding = std::ranges::find(d.findings, effect.name(), &Finding::effect);
    std::optional<Stage> less;
    if (finding != d.findings.end() && lasts(effect)) less = extender.without(e);
    const bool needless =
        less && less->result().converged() &&
        is_chance(less->result().cost_final - extender.stage().result().cost_final, level,
                  effect.size());
    if (!needless) {
      ++e;
      continue;
    }
    d.findings.erase(finding);
    extender.replace(*less);
  }
}

// Does the model that has the clock, with held readings, explain all of the pattern?
bool is_held(const OwnClock& clock, const NoiseOf& of, double level) {
  return std::ranges::all_of(of.residuals, [&](const SampleResiduals& s) {
    return s.channel != Sensor::kMag || leaves_no_pattern(clock, s, level);
  });
}

// The model with the alternating field in it, where a fit of that converges.
void extend_by_mains(const Pipeline& pipeline, Extender& extender, Finding& finding) {
  if (finding.effect != "mains_interference" || finding.parameters.size() < 7) return;
  ModelSpec spec = extender.stage().spec();
  spec.effects.push_back(
      make_mains_at(finding.parameters[6].value, is_of_room(finding.parameters)));
  // Without a fit of it the line stays a finding in the samples.
  attempt([&] {
    const Stage stage = pipeline.refit(extender.stage(), spec);
    if (stage.result().converged()) extender.replace(stage);
    return true;
  });
}

}  // namespace

namespace {

std::optional<Finding> take_out_saturated(Recording& recording, const DiagnosisOptions& options) {
  VectorSeries& mag = recording.mag.front();
  if (mag.size() < kLeastSamples) return std::nullopt;
  const SampleResiduals samples{.channel = Sensor::kMag,
                                .t = mag.t,
                                .reading = mag.v,
                                .residual = high_passed(mag),
                                .high_passed = true};
  for (const NoiseTest& t : test_noise({samples})) {
    if (t.effect != "mag_saturation" || !t.untested.empty()) continue;
    if (t.p_value > options.false_alarm_rate / kTests) continue;
    const double limit = t.parameters.front().value;
    // Near the limit the samples that are left are those whose noise pointed away from it, and a
    // fit would take that for an error of the sensor. So a sample is taken out where the quadratic
    // through its neighbours comes near the limit, whatever its own reading is. That quadratic's
    // value is the reading less its high-passed part over 1 - c_0.
    const Vector3 margin =
        kBelowLimit *
        robust_scale(samples.residual, std::vector<char>(samples.residual.size(), 1)) /
        std::sqrt(kHighPassVariance);
    VectorSeries kept;
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const Vector3 neighbours = mag.v[k] - samples.residual[k] / (1.0 - smoothing_weight(0));
      if (mag.v[k].cwiseAbs().maxCoeff() < limit * (1.0 - 1e-9) &&
          (neighbours.cwiseAbs() + margin).maxCoeff() < limit) {
        kept.push_back(mag.t[k], mag.v[k]);
      }
    }
    if (kept.size() < mag.size() / 2) return std::nullopt;
    mag = std::move(kept);
    return to_finding(t);
  }
  return std::nullopt;
}

// Of high-passed samples of white noise with this density.
double high_passed_variance(const SampleResiduals& samples, double density) {
  const double interval = (samples.t.back() - samples.t.front()) / double(samples.t.size() - 1);
  return kHighPassVariance * density * density / interval;
}

// Is what the gyroscope's samples have beyond a smooth motion no noise, but motion? As noise it
// would be so many times the fit's own that its residuals would show it (a hand that trembles, a
// table that turns in steps): errors of v times the variance leave at least v (1 - h) times the
// squares, h the share that the fit absorbs; motion leaves what noise does.
bool is_motion(const SampleResiduals& gyr, const Stage& stage) {
  constexpr double kBeyondChance = 5.0;  // standard deviations
  const SensorSums sums = stage.sums();
  const auto s = std::size_t(Sensor::kGyr);
  double squares = 0.0, n = 0.0;
  for (std::size_t k = 0; k < gyr.residual.size(); ++k) {
    if (!gyr.residual[k].allFinite()) continue;
    squares += gyr.residual[k].squaredNorm();
    n += 3.0;
  }
  if (n == 0.0 || gyr.t.size() < 2 || !(sums.rows[s] > 0.0)) return false;
  const double times = squares / n / high_passed_variance(gyr, stage.spec().noise.gyr);
  const double as_noise = times * (1.0 - sums.absorbed[s] / sums.rows[s]);
  const double seen = std::pow(sums.rms(Sensor::kGyr), 2);
  return as_noise > 1.0 + kBeyondChance * std::sqrt(2.0 / sums.rows[s]) &&
         seen < std::sqrt(as_noise);
}

// Is most of what is faster than the trajectory a hand's tremor? As noise it would be far more than
// the fit finds.
bool is_mostly_motion(const SampleResiduals& acc, const Stage& stage) {
  constexpr double kMostly = 2.0;  // times the noise: more than half is something else
  if (!acc.high_passed || acc.t.size() < 2) return false;
  std::vector<char> used;
  for (const Vector3& x : acc.residual) used.push_back(x.allFinite() ? 1 : 0);
  const double seen = robust_scale(acc.residual, used).squaredNorm() / 3.0;
  return seen > kMostly * high_passed_variance(acc, stage.spec().noise.acc);
}

// Takes the chosen tests for untested.
void take_for_untested(NoiseOf& of, const std::function<bool(const NoiseTest&)>& chosen,
                       const std::string& why) {
  std::erase_if(of.causes, chosen);
  for (NoiseTest& t : of.tests) {
    if (chosen(t)) t = untested(t.effect, t.channel, why);
  }
}

// What is left of readings that stay on a step shows the step and no noise.
void take_rounding_out(const SampleResiduals& samples, const Recording& recording, NoiseOf& of) {
  if (samples.channel == Sensor::kMag) return;  // whose steps are told from its noise
  const bool acc = samples.channel == Sensor::kAcc;
  if (!coarse_steps(acc ? recording.acc : recording.gyr)) return;
  take_for_untested(
      of, [&](const NoiseTest& t) { return t.channel == samples.channel; },
      "its readings are rounded more coarsely than they are noisy");
}

void take_motion_out(const SampleResiduals& samples, const Stage& stage, NoiseOf& of) {
  if (samples.channel == Sensor::kGyr && is_motion(samples, stage)) {
    take_for_untested(
        of, [](const NoiseTest& t) { return t.channel == Sensor::kGyr; },
        "the sensor itself turned as irregularly as noise, as the others confirm");
  }
  // A tremor has a colour of its own.
  if (samples.channel == Sensor::kAcc && is_mostly_motion(samples, stage)) {
    take_for_untested(
        of,
        [](const NoiseTest& t) {
          return t.channel == Sensor::kAcc && t.effect == "correlated_noise";
        },
        "most of what is faster than the trajectory is the hand's tremor, not noise");
  }
}

// The one to report of the same test in several recordings: that which shows most.
bool shows_more(const NoiseTest& a, const NoiseTest& b) {
  if (a.untested.empty() != b.untested.empty()) return a.untested.empty();
  return a.p_value != b.p_value ? a.p_value < b.p_value : a.statistic > b.statistic;
}

// Of each test the strongest, as one of so many.
std::vector<NoiseTest> strongest(const std::vector<NoiseOf>& all) {
  std::vector<NoiseTest> out = all.front().tests;
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (const NoiseOf& other : all) {
      if (shows_more(other.tests[i], out[i])) out[i] = other.tests[i];
    }
    out[i].p_value = std::min(1.0, out[i].p_value * double(all.size()));
  }
  return out;
}

// The device is the same: a cause found in several recordings is one, and what each gains adds up.
std::vector<NoiseTest> united_causes(const std::vector<NoiseOf>& all) {
  std::vector<NoiseTest> out;
  for (const NoiseTest& t : all.front().tests) {
    std::optional<NoiseTest> best;
    double before = 0.0, after = 0.0;
    for (const NoiseOf& of : all) {
      const auto cause = std::ranges::find_if(of.causes, [&](const NoiseTest& c) {
        return c.effect == t.effect && c.channel == t.channel;
      });
      if (cause == of.causes.end()) continue;
      before += cause->nll_before;
      after += cause->nll_after;
      if (!best || shows_more(*cause, *best)) best = *cause;
    }
    if (!best) continue;
    best->p_value = std::min(1.0, best->p_value * double(all.size()));
    best->nll_before = before;
    best->nll_after = after;
    out.push_back(*std::move(best));
  }
  return out;
}

// In the order in which they are explained: what the later ones are is said beside the earlier.
void in_order_of_explanation(std::vector<NoiseTest>& causes) {
  static const std::vector<std::string> order = {"mag_saturation",     "mag_quantization",
                                                 "mains_interference", "outliers",
                                                 "correlated_noise",   "noise_scale"};
  std::ranges::stable_sort(causes, {}, [&](const NoiseTest& t) {
    return std::pair(int(t.channel), std::ranges::find(order, t.effect) - order.begin());
  });
}

// Neighbouring samples depend on each other beyond doubt, but not as noise with a memory does.
void tell_what_has_no_name(const std::vector<NoiseTest>& tests,
                           const std::vector<NoiseTest>& causes, bool acc_high_passed,
                           Diagnosis& d) {
  for (const NoiseTest& t : tests) {
    if (t.effect != "correlated_noise" || t.untested.empty()) continue;
    // Of a channel that the trajectory follows only what is faster is seen, and that may be motion.
    if (t.channel == Sensor::kGyr || (t.channel == Sensor::kAcc && acc_high_passed)) continue;
    // Coloured or heavy-tailed noise that has a name makes one of the other tests doubtful.
    if (std::ranges::any_of(causes, [&](const auto& c) { return c.channel == t.channel; }))
      continue;
    if (chi_square_tail(t.statistic, std::max(1, t.dof)) > level_of_one(kStatisticsOfOne)) continue;
    add_evidence(
        d, t.channel,
        fmt::format("What is left of the {}'s samples is not white (chi-square {:.0f} with {} "
                    "degree{} of freedom), but it is not noise with a memory either: {}.",
                    in_words(t.channel), t.statistic, std::max(1, t.dof), t.dof > 1 ? "s" : "",
                    t.untested));
  }
}

}  // namespace

bool is_size_of_noise(const Finding& f) {
  return f.effect == "noise_scale" || f.effect == "correlated_noise" || f.effect == "outliers";
}

void take_out_saturated(std::vector<Recording>& recordings, const DiagnosisOptions& options,
                        Diagnosis& d) {
  std::optional<Finding> strongest;
  for (Recording& r : recordings) {
    std::optional<Finding> f = take_out_saturated(r, options);
    if (f && (!strongest || f->p_value < strongest->p_value)) strongest = std::move(f);
  }
  if (strongest) d.findings.push_back(*std::move(strongest));
}

void take_out_clock(const Diagnosis& d, const Stage& stage, double level,
                    std::vector<SampleResiduals>& residuals) {
  const bool found =
      std::ranges::find(d.findings, "mag_own_clock", &Finding::effect) != d.findings.end();
  if (!found || has_clock(stage)) return;
  for (SampleResiduals& samples : residuals) {
    if (samples.channel != Sensor::kMag) continue;
    if (const auto clock = find_own_clock(samples, level)) {
      take_out_own_clock(clock->period_s, clock->share, samples);
    }
  }
}

void find_noise(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const DiagnosisOptions& options, bool turned, Extender& extender, Diagnosis& d) {
  const double level = options.false_alarm_rate / kTests;
  std::vector<NoiseOf> all(recordings.size());
  const auto take_residuals = [&] {
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      all[r].residuals = sample_residuals(*recordings[r], extender.stage(), int(r),
                                          pipeline.rest_noise(), options.noise.has_value());
    }
  };
  take_residuals();
  std::optional<OwnClock> clock;
  if (turned) {
    clock = has_ages_of_samples(recordings) ? clock_of_fits(*recordings.front(), pipeline, options,
                                                            extender.stage(), all.front(), level)
                                            : strongest_clock(all, level);
  }
  if (clock) {
    extend_by_clock(recordings, pipeline, extender, *clock, level, d);
    if (has_clock(extender.stage())) withdraw_beside_clock(extender, level, d);
    take_residuals();
    if (has_clock(extender.stage()) && !clock->is_slow()) {
      clock->held = is_held(*clock, all.front(), level);
    }
    if (clock->held) clock->reach_s = clock->period_s;
    d.findings.push_back(to_finding(own_clock_test(*clock)));
  }
  d.scan.push_back(entry_of_clock(clock, level));
  if (!turned) d.scan.back().needs = kHardlyTurned;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    take_out_clock(d, extender.stage(), level, all[r].residuals);
    all[r].tests = test_noise(all[r].residuals);
    all[r].causes = explain_noise(all[r].residuals, level / double(recordings.size()));
    for (const SampleResiduals& s : all[r].residuals) {
      take_motion_out(s, extender.stage(), all[r]);
      take_rounding_out(s, *recordings[r], all[r]);
    }
  }
  const std::vector<NoiseTest> tests = strongest(all);
  for (const NoiseTest& t : tests) d.scan.push_back(to_entry(t, level));
  std::vector<NoiseTest> causes = united_causes(all);
  in_order_of_explanation(causes);
  const bool blows = std::ranges::any_of(
      all, [](const NoiseOf& of) { return shows_blows(of.residuals.front(), of.tests); });
  if (blows) {
    add_evidence(
        d, Sensor::kAcc,
        "What sticks out of the accelerometer comes several samples at a time, as blows to "
        "the sensor make it: tapped, knocked, or put down?");
    std::erase_if(causes, [](const NoiseTest& t) { return t.channel == Sensor::kAcc; });
  }
  tell_what_has_no_name(tests, causes, all.front().residuals.front().high_passed, d);
  for (const NoiseTest& t : causes) {
    if (imitated_by_colour(t, causes)) continue;
    if (int(d.findings.size()) >= options.max_findings) break;
    Finding f = to_finding(t);
    extend_by_mains(pipeline, extender, f);
    d.findings.push_back(std::move(f));
  }
}

namespace {

// Its amplitude, uT.
double size_of_line(const Finding& line) {
  double squares = 0.0;
  // At half the sampling rate sine and cosine cannot be told apart: one of them has no sigma.
  for (const FoundParameter& p : line.parameters) {
    if (p.unit == "uT" && p.sigma < std::abs(p.value)) squares += p.value * p.value;
  }
  return std::sqrt(squares);
}

// n if the line is a pattern of every n-th sample (n = 2, 3, 4); else 0. The mains' frequency
// wanders by hundredths of a hertz, so that it equals a fraction of the sampling rate by chance
// only.
int samples_of_pattern(const Finding& line, double rate_hz) {
  if (is_of_room(line.parameters)) return 0;          // rows that are mixed turn with their sensors
  constexpr double kWithin = 3.0, kOfTheGrid = 0.01;  // standard deviations; Hz
  const FoundParameter& f = line.parameters.back();
  for (int n = 2; n <= 4; ++n) {
    const double off = std::abs(f.value - rate_hz / n);
    if (off < kWithin * f.sigma && kWithin * f.sigma < kOfTheGrid) return n;
  }
  return 0;
}

}  // namespace

void withdraw_other_lines(const std::vector<const Recording*>& recordings, Diagnosis& d) {
  const auto line = std::ranges::find(d.findings, "mains_interference", &Finding::effect);
  if (line == d.findings.end()) return;
  const double f_hz = line->parameters.back().value;
  const auto of_mains = [&](const Recording* r) {
    return is_mains(f_hz, r->mag.front().rate_hz());
  };
  if (const int n = samples_of_pattern(*line, recordings.front()->mag.front().rate_hz()); n > 0) {
    constexpr const char* kOrdinal[] = {"second", "third", "fourth"};
    add_evidence(
        d, Sensor::kMag,
        fmt::format("Every {} sample of the magnetometer stands out by {:.2g} uT, all along "
                    "and in step with its clock, which no alternating field is: rows of two "
                    "sensors or devices are mixed, or the sensor takes turns. Separate them.",
                    kOrdinal[n - 2], size_of_line(*line)));
    // What else the samples of such a mixture show is the mixture.
    std::erase_if(d.findings, [](const Finding& f) {
      return f.channel == "mag" && (f.effect == "mains_interference" || is_size_of_noise(f));
    });
    return;
  }
  if (std::ranges::any_of(recordings, of_mains)) return;
  const auto interpolated = [](const Recording* r) {
    return std::ranges::any_of(check_recording(*r), [](const Issue& i) {
      return i.kind == "interpolation" && i.sensor.starts_with("mag");
    });
  };
  if (std::ranges::none_of(recordings, interpolated)) return;
  add_evidence(d, Sensor::kMag,
               fmt::format("A line stands at {:.4g} Hz in the magnetometer's samples, which is "
                           "neither 50 nor 60 Hz. They are interpolated between measurements, "
                           "which makes such lines: it is not named mains.",
                           f_hz));
  d.findings.erase(line);
}

}  // namespace magimu
