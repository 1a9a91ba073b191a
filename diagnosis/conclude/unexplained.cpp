// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/unexplained.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "calibration/fit/residual_series.h"
#include "calibration/model/windows.h"
#include "calibration/scan/general_dependence.h"
#include "diagnosis/conclude/noise_findings.h"
#include "diagnosis/noise/noise_by_rate.h"
#include "diagnosis/noise/noise_causes.h"
#include "diagnosis/noise/sample_residuals.h"
#include "diagnosis/noise/timing_noise.h"
#include "diagnosis/result/sentence_words.h"
#include "recording/checks/repeats.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kGrown = 1.1;     // RMS in fast motion over that in slow
constexpr double kVague = 0.03;    // of the clearest direction
constexpr double kRateCare = 1.0;  // log10 of a probability
constexpr double kTailCare = 2.0;  // log10 of a probability: far tails under coloured noise
constexpr double kCrumbs = 0.03;   // of what a finding in that channel explained
// Repeated samples of an IMU, of all: fewer do no harm.
constexpr double kRepeats = 0.01;
constexpr double kOwnToRepeats = 2.0;  // times their share: correlation or outliers that they make
constexpr double kOwnToJitter = 2.0;   // times the variance that it adds
constexpr double kSameLine = 0.1;      // of the frequency of its pattern
constexpr double kOwn = 0.5;  // of what a cause explains, beside a dependence without a name
// In units of what a finding explains: with more than this left in its own channel, or in another
// one, its name is doubtful.
constexpr double kLeftElsewhere = 3.0;

// log10 of the probability by those directions alone that the data show clearly. Columns are made
// at estimated attitudes: an error eps of these (rad), which goes along with the node's own
// residual, gives the score of a direction, in its standard deviations, up to sqrt(nodes) eps / a,
// with a its part of the clearest direction at sizes that are plausible. Some thousand nodes and
// 5e-4 rad make that one at 0.03.
double log10_p_of_clear_directions(const Score& s, double duration_s) {
  const VectorXd prior = s.effect->prior_sigma(duration_s);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(prior.asDiagonal() * s.information * prior.asDiagonal()));
  const VectorXd z =
      eigen.eigenvectors().transpose() * (prior.asDiagonal() * (s.information * s.theta)).eval();
  const VectorXd& clear = eigen.eigenvalues();
  double statistic = 0.0, dof = 0.0;
  for (Eigen::Index i = 0; i < clear.size(); ++i) {
    if (!(clear[i] > kVague * kVague * clear.maxCoeff())) continue;
    statistic += z[i] * z[i] / clear[i];
    dof += 1.0;
  }
  return dof > 0.0 ? log10_chi_square_tail(statistic / std::max(1.0, s.scatter), dof) : 0.0;
}

std::vector<std::shared_ptr<const Effect>> all_dependences(MotionModel motion) {
  auto all = general_dependences(is_moved(motion));
  for (auto& other : dependences_on_other_sensors()) all.push_back(std::move(other));
  return all;
}

// Dependences without a name, each by the scatter that is left with it in the model.
std::vector<Score> scores_of(const std::vector<const Recording*>& recordings, const Stage& stage,
                             MotionModel motion) {
  auto all = all_dependences(motion);
  const auto acc = std::stable_partition(
      all.begin(), all.end(), [](const auto& e) { return e->channel() != Sensor::kAcc; });
  std::vector<Score> out;
  const auto look = [&](auto begin, auto end) {
    if (begin == end) return;
    const Scan scan(recordings, stage, {begin, end}, window_s((*begin)->channel(), motion));
    for (std::size_t i = 0; i < scan.scores().size(); ++i) {
      Score s = scan.with_own_scatter(i);
      // Where the hand's motion takes up most of what windows show, the rest lies in frequencies
      // too low to tell colour from a dependence: it must be seen within windows, too.
      s.log10_p = std::max(
          s.log10_p, log10_chi_square_tail(s.in_windows / std::max(1.0, s.scatter), double(s.dof)));
      s.log10_p =
          std::max(s.log10_p, log10_p_of_clear_directions(s, recordings.front()->duration_s()));
      out.push_back(s);
    }
  };
  look(all.begin(), acc);
  look(acc, all.end());
  return out;
}

// What a finding explained, from the figures it carries.
double misfit_of(const Finding& f) {
  return 2.0 * (f.gain.heldout_nll_before - f.gain.heldout_nll_after);
}

// Of all findings in a channel but the hand's motion.
double explained_of(const Diagnosis& d, Sensor channel) {
  double explained = 0.0;
  for (const Finding& f : d.findings) {
    if (f.channel == to_string(channel) && f.effect != "linear_acceleration") {
      explained = std::max(explained, misfit_of(f));
    }
  }
  return explained;
}

// How many times of what a finding explains must be left in the channel to make it doubtful.
double doubtful_from(const Finding& f, const std::string& channel) {
  const bool of_the_mean = find_effect(f.effect) != nullptr || f.effect == "noise_scale";
  const bool elsewhere = f.channel != channel;
  if (f.effect == "linear_acceleration" || (elsewhere && !of_the_mean)) return INFINITY;
  return of_the_mean && !elsewhere ? kLeftOver : kLeftElsewhere;
}

// Withdraws findings beside which too much is left. In a finding's own channel (kLeftOver) it stood
// for the real cause; what is left in another channel, or beside a cause of noise (kLeftElsewhere),
// may have made the finding.
void withdraw_doubtful(const std::string& channel, double left, Diagnosis& d) {
  std::erase_if(d.findings, [&](const Finding& f) {
    const double from = doubtful_from(f, channel);
    if (!(misfit_of(f) > 0.0) || !(left > from * misfit_of(f))) return false;
    d.structure.evidence.push_back(
        from < 1.0
            ? fmt::format("The cause \"{}\" explained a part of it, and is not named because "
                          "more than {:.0f} % as much is left.",
                          effect_words(f.effect), 100.0 * from)
            : fmt::format("The cause \"{}\" ({}) may be its shadow: it explains less than a "
                          "third of what is left here, and is not named.",
                          effect_words(f.effect), effect_words(f.channel)));
    return true;
  });
}

// Splits a series of all recordings, node by node, into one for each recording.
std::vector<ResidualSeries> by_recording(const ResidualSeries& all,
                                         const std::vector<NodePlan>& plans) {
  std::vector<ResidualSeries> out(plans.size());
  std::size_t p = 0, node = 0;
  for (std::size_t i = 0; i < all.t.size(); ++i) {
    while (p < plans.size()) {
      const auto& t = plans[p].t;
      const auto at = std::find(t.begin() + std::ptrdiff_t(node), t.end(), all.t[i]);
      if (at != t.end()) {
        node = std::size_t(at - t.begin()) + 1;
        break;
      }
      ++p;
      node = 0;
    }
    if (p == plans.size()) break;
    out[p].t.push_back(all.t[i]);
    out[p].whitened.push_back(all.whitened[i]);
  }
  return out;
}

// Errors that change from sample to sample, more so in motion.
void grow_with_rate(const std::vector<const Recording*>& recordings,
                    const DiagnosisOptions& options, const Stage& stage, Diagnosis& d) {
  const auto series = residual_series(stage, recordings.front()->mag_names);
  const double level = std::log10(options.false_alarm_rate / 3.0 / double(recordings.size()));
  for (const Sensor channel : {Sensor::kAcc, Sensor::kMag}) {
    // The trajectory follows a hand-held accelerometer.
    if (channel == Sensor::kAcc && is_moved(stage.spec().motion)) continue;
    NoiseByRate seen;
    const std::vector<ResidualSeries> parts =
        by_recording(series[std::size_t(channel)], stage.plans());
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      const NoiseByRate here = noise_by_rate(parts[r], *recordings[r]);
      if (here.log10_p < seen.log10_p) seen = here;
    }
    if (seen.log10_p > level - kRateCare || seen.fast_over_slow < kGrown) continue;
    if (seen.statistic < kCrumbs * explained_of(d, channel)) continue;
    add_evidence(
        d, channel,
        fmt::format("What is left of the {} is {:.2f} times as large where the sensor turns fast "
                    "as where it turns slowly (p = {:.1g}), beside what has a cause here.",
                    in_words(channel), seen.fast_over_slow, std::pow(10.0, seen.log10_p)));
  }
}

// Does the jitter explain the finding? Noise that is larger than given, or outliers, if the jitter
// adds half of their variance or more; a line, if it is a harmonic of the jitter's pattern.
bool is_made_by(const TimingNoise& jitter, const Finding& f) {
  const double value = f.parameters.front().value;
  const double most = kOwnToJitter * jitter.added;
  if (f.effect == "mains_interference") {
    const double multiple = f.parameters.back().value * jitter.period_s;
    return std::round(multiple) > 0.0 && std::abs(multiple - std::round(multiple)) < kSameLine;
  }
  if (f.effect == "noise_scale") return value > 1.0 && value * value - 1.0 < most;
  return f.effect == "outliers" && value * std::pow(f.parameters[1].value, 2) < most;
}

std::string why_off(const TimingNoise& seen) {
  if (seen.period_s <= 0.0) {
    return "each by its own amount, as a clock that jitters or times taken when the bus was read "
           "make it";
  }
  return fmt::format(
      "in a pattern that repeats every {:.3g} ms, as where a sensor measures on a clock of its own "
      "and is read on another one",
      1e3 * seen.period_s);
}

// The model without its line of the mains, if it has one: the line may be a harmonic of the pattern
// in the times that is looked for.
std::optional<Stage> without_line(const Extender& extender) {
  const auto& effects = extender.stage().spec().effects;
  const auto line = std::ranges::find_if(
      effects, [](const auto& e) { return e->name() == "mains_interference"; });
  if (line == effects.end()) return std::nullopt;
  return extender.without(std::size_t(line - effects.begin()));
}

// Samples of other times than they say.
void find_timing_noise(const std::vector<const Recording*>& full, const DiagnosisOptions& options,
                       const Stage& stage, Diagnosis& d) {
  const double level = std::log10(options.false_alarm_rate / 3.0) - kRateCare;
  for (std::size_t r = 0; r < full.size(); ++r) {
    std::vector<SampleResiduals> all = sample_residuals(*full[r], stage, int(r), {}, false);
    take_out_clock(d, stage, options.false_alarm_rate, all);
    for (const SampleResiduals& samples : all) {
      // Rounding errs only where the reading changes, and so along its change.
      const bool rounded = std::ranges::any_of(d.findings, [&](const Finding& f) {
        return f.effect == "mag_quantization" && f.channel == to_string(samples.channel);
      });
      const TimingNoise seen = timing_noise(samples);
      if (rounded || seen.log10_p > level) continue;
      add_evidence(
          d, samples.channel,
          fmt::format(
              "What is left of the {} lies along the change of its reading more than across it (p "
              "= {:.1g}), as if its samples' times were off by some {:.2g} ms: {}.",
              in_words(samples.channel), std::pow(10.0, std::max(seen.log10_p, -99.0)),
              1e3 * seen.jitter_s, why_off(seen)));
      std::erase_if(d.findings, [&](const Finding& f) {
        if (f.channel != to_string(samples.channel) || !is_made_by(seen, f)) return false;
        if (f.effect == "mains_interference") {
          add_evidence(
              d, samples.channel,
              fmt::format(
                  "The {}'s line at {:.1f} Hz is a harmonic of that pattern, not the mains.",
                  in_words(samples.channel), f.parameters.back().value));
        }
        return true;
      });
    }
  }
}

// What the second candidate of a scan explains beside the first: nats, its parameters paid for, and
// how many directions it adds. None: it is a special case of the first.
struct Beside {
  double nats;
  int directions;
};
Beside explained_beside(const Scan& scan) {
  const Eigen::Index first = scan.first(1), all = scan.information().rows();
  const Score both = scan.combined(MatrixXd::Identity(all, all));
  const Score one = scan.combined(MatrixXd::Identity(all, first));
  const int directions = both.dof - one.dof;
  return {0.5 * (both.statistic - one.statistic) - double(directions), directions};
}

// An effect in the model can stand for another cause that looks alike in this motion, a function of
// time most easily. It is withdrawn if a dependence without a name explains clearly more, its
// parameters paid for, and leaves the effect little to explain. (A line of the mains depends on no
// motion and is left out.)
void withdraw_stand_ins(const std::vector<const Recording*>& recordings, Extender& extender,
                        Diagnosis& d) {
  const Stage& stage = extender.stage();
  const auto& effects = stage.spec().effects;
  for (std::size_t e = 0; e < effects.size(); ++e) {
    const auto finding = std::ranges::find_if(
        d.findings, [&](const Finding& f) { return f.effect == effects[e]->name(); });
    if (finding == d.findings.end() || effects[e]->name() == "mains_interference") continue;
    auto all = all_dependences(stage.spec().motion);
    std::erase_if(all, [&](const auto& a) { return a->channel() != effects[e]->channel(); });
    const std::optional<Stage> without = extender.without(e);
    if (!without) continue;
    all.push_back(effects[e]);
    const Scan scan(recordings, *without, all);
    const double worth = extender.worth(e, *without);
    // By one step as the dependences are: of a large effect one step promises more than a fit
    // gives.
    const Score& own = scan.scores().back();
    const double own_worth = std::max(worth, 0.5 * own.statistic - double(own.dof));
    double most = own_worth + kDraw;
    Score best;
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      const Score s = scan.with_own_scatter(i);
      const double nameless = 0.5 * s.statistic - double(s.dof) * std::max(1.0, s.scatter);
      if (nameless <= most) continue;
      most = nameless;
      best = s;
    }
    if (!best.effect) continue;
    const Beside beside = explained_beside(Scan(recordings, *without, {best.effect, effects[e]}));
    // What contains the effect explains a little more of whatever it explains.
    const bool is_special_case = beside.directions == 0 && kAsMuch * most < own_worth;
    if (is_special_case || beside.nats > kOwn * worth) continue;
    add_evidence(
        d, best.effect->channel(),
        fmt::format("The {} depends {} (chi-square {:.0f} with {} degrees of freedom), as "
                    "no cause does that is known here; the cause \"{}\" would explain less "
                    "of the same, and is not named.",
                    in_words(best.effect->channel()), best.effect->description().cause,
                    best.statistic, best.dof, effect_words(finding->effect)));
    d.findings.erase(finding);
  }
}

// A blow is shorter than a sampling interval. Its change of velocity and position is in no sample,
// and errors of the accelerometer can imitate that change.
void withdraw_beside_blows(const Stage& stage, Diagnosis& d) {
  constexpr double kStruck = 0.01, kBlow = 10.0;  // of the samples; times the noise
  const auto blows = std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) {
    return f.effect == "outliers" && f.channel == to_string(Sensor::kAcc);
  });
  if (!is_moved(stage.spec().motion) || blows == d.findings.end()) return;
  const double share = blows->parameters[0].value, times = blows->parameters[1].value;
  if (share < kStruck || times < kBlow) return;
  std::erase_if(d.findings, [&](const Finding& f) {
    const auto effect = find_effect(f.effect);
    if (!effect || effect->channel() != Sensor::kAcc) return false;
    add_evidence(
        d, Sensor::kAcc,
        fmt::format("The cause \"{}\" is not named: {:.2g} % of the accelerometer's samples "
                    "are blows, which move the sensor in ways that it can imitate.",
                    effect_words(f.effect), 100.0 * share));
    return true;
  });
}

struct StrongestDependence {
  Sensor channel = Sensor::kMag;
  double misfit = 0.0;  // chi-square beyond its degrees of freedom
};

// Of the model at its end.
StrongestDependence look_for_dependences(const std::vector<const Recording*>& recordings,
                                         const std::vector<const Recording*>& full,
                                         const DiagnosisOptions& options, const Extender& extender,
                                         Diagnosis& d) {
  const Stage& stage = extender.stage();
  const std::vector<Score> scores = scores_of(recordings, stage, stage.spec().motion);
  const double level = std::log10(options.false_alarm_rate / 3.0 / double(scores.size()));
  StrongestDependence strongest;
  for (const Score& s : scores) {
    if (s.log10_p > level - (s.coloured ? kTailCare : 0.0)) continue;
    // Beside a large effect its own approximations show.
    if (s.statistic - s.dof < kCrumbs * explained_of(d, s.effect->channel())) continue;
    add_evidence(d, s.effect->channel(),
                 fmt::format("What is left of the {} depends {} (chi-square {:.0f} with {} degrees "
                             "of freedom): no cause that is known here acts so.",
                             in_words(s.effect->channel()), s.effect->description().cause,
                             s.statistic, s.dof));
    if (s.statistic - s.dof > strongest.misfit) {
      strongest = {s.effect->channel(), s.statistic - s.dof};
    }
  }
  grow_with_rate(recordings, options, stage, d);
  const std::optional<Stage> lineless = without_line(extender);
  find_timing_noise(full, options, lineless ? *lineless : stage, d);
  return strongest;
}

// What a search adds to d.structure, returned instead of added.
template <class Search>
Unexplained apart(Diagnosis& d, const Search& search) {
  const Unexplained before = std::exchange(d.structure, {});
  search();
  return std::exchange(d.structure, before);
}

}  // namespace

void add_evidence(Diagnosis& d, Sensor channel, std::string sentence) {
  auto& channels = d.structure.channels;
  d.structure.detected = true;
  if (std::ranges::find(channels, to_string(channel)) == channels.end()) {
    channels.push_back(to_string(channel));
  }
  d.structure.evidence.push_back(std::move(sentence));
}

void find_repeats(const std::vector<const Recording*>& recordings, Diagnosis& d) {
  const auto count = [&](Sensor channel, const VectorSeries& series, double least, double most) {
    const Repeats repeats = repeats_in(series);
    if (!repeats.beyond_chance() || repeats.share < least || repeats.share > most) return;
    add_evidence(
        d, channel,
        fmt::format("{:.2g} % of the {}'s samples are the one before once more ({} of them): lost "
                    "on their way and filled in, or read twice? Look at the logger and the bus.",
                    100.0 * repeats.share, in_words(channel), repeats.seen));
    std::erase_if(d.findings, [&](const Finding& f) {
      return (f.effect == "correlated_noise" || f.effect == "outliers") &&
             f.channel == to_string(channel) &&
             f.parameters.front().value < kOwnToRepeats * repeats.share;
    });
  };
  for (const Recording* recording : recordings) {
    count(Sensor::kAcc, recording->acc, kRepeats, 1.0);
    count(Sensor::kGyr, recording->gyr, kRepeats, 1.0);
    for (const VectorSeries& mag : recording->mag) {
      count(Sensor::kMag, mag, kFewRepeats, kSomeRepeats);
    }
  }
}

Unexplained unexplained_beside(const std::vector<const Recording*>& recordings,
                               const std::vector<const Recording*>& full,
                               const DiagnosisOptions& options, const Extender& extender,
                               Diagnosis& d) {
  return apart(d, [&] { look_for_dependences(recordings, full, options, extender, d); });
}

Dependences find_unexplained(const std::vector<const Recording*>& recordings,
                             const std::vector<const Recording*>& full,
                             const DiagnosisOptions& options, Extender& extender, Diagnosis& d) {
  withdraw_beside_blows(extender.stage(), d);
  withdraw_stand_ins(recordings, extender, d);
  Dependences out;
  out.at = d.structure.evidence.size();
  StrongestDependence strongest;
  out.left =
      apart(d, [&] { strongest = look_for_dependences(recordings, full, options, extender, d); });
  withdraw_doubtful(to_string(strongest.channel), strongest.misfit, d);
  return out;
}

void add_unexplained(Dependences dependences, Diagnosis& d) {
  Unexplained& to = d.structure;
  Unexplained& left = dependences.left;
  to.detected |= left.detected;
  to.evidence.insert(to.evidence.begin() + std::ptrdiff_t(dependences.at),
                     std::make_move_iterator(left.evidence.begin()),
                     std::make_move_iterator(left.evidence.end()));
  for (const std::string& channel : left.channels) {
    if (std::ranges::find(to.channels, channel) == to.channels.end())
      to.channels.push_back(channel);
  }
}

}  // namespace magimu
