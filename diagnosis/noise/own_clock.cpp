// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/own_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "diagnosis/noise/high_pass.h"
#include "statistics/power_spectrum.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr std::size_t kFewestForClock = 2000;
constexpr double kSlowestPatternHz = 1.0 / kSlowPattern;
constexpr double kShortestPeriod = 1e-3, kLongestPeriod = 0.05;  // s
constexpr double kNeighbourhoodHz = 2.0;  // whose median is the level of the noise, to each side
constexpr double kMostAcross = 0.25;      // of the line's height along the change
constexpr double kStretch = 10.0;         // s
constexpr double kFewestTeeth = 3.0;      // of a sawtooth: fewer are a lag that drifts
// Of a slow pattern, whose clocks fits compare; of harmonics beyond kFoldedOften the first fold
// only.
constexpr int kMostFolds = 3, kMostHarmonics = 8, kFoldedOften = 2;
constexpr double kLongestSearch = 300.0;  // s: slow patterns begin there, and grow to the whole
constexpr double kMostNats = 690.0;       // whose exponential is a number

double sawtooth(double t, double period_s, double share) {
  const double turns = t / period_s + share;
  return period_s * (turns - std::floor(turns));
}

// How ages are compared with samples: by which of the numbers of Explained, and what attitudes have
// left of the ages: a spike about each jump, of this share of the period (all of it: the sawtooth).
struct Explained;
struct Measure {
  double Explained::*nats = nullptr;
  double width = 1.0;
};

// Less its mean over a stretch as long as that share.
double left_of_sawtooth(double t, double period_s, double share, double width) {
  if (width >= 1.0) return sawtooth(t, period_s, share);
  const double turns = t / period_s + share, phase = turns - std::round(turns);  // of the next jump
  if (std::abs(phase) >= 0.5 * width) return 0.0;
  return period_s * (phase / width - std::copysign(0.5, phase));
}

// The residuals e projected on the reading's change d and on c across it, sample by sample.
struct Ages {
  std::vector<double> t, said, across;  // s; -d' e and -c' e over the noise's variance
  std::vector<double> weight;           // d' d over it: information on the sample's age, 1/s^2
  double rate_hz = 0.0;
};

Ages ages_of(const SampleResiduals& mag) {
  Ages out;
  VectorSeries series;
  for (std::size_t k = 0; k < mag.t.size(); ++k) series.push_back(mag.t[k], mag.residual[k]);
  out.rate_hz = series.rate_hz();
  const std::vector<Vector3> fast = high_passed(series);
  std::vector<double> squares;
  for (const Vector3& e : fast) squares.push_back(e.squaredNorm());
  constexpr double kMedianOfThree = 2.366;  // chi-square with three degrees of freedom
  const double variance = std::max(median(squares) / kMedianOfThree / kHighPassVariance, 1e-300);
  for (std::size_t k = 0; k < mag.t.size(); ++k) {
    if (!mag.residual[k].allFinite()) continue;
    out.t.push_back(mag.t[k]);
    out.said.push_back(-mag.change[k].dot(mag.residual[k]) / variance);
    out.across.push_back(-mag.across[k].dot(mag.residual[k]) / variance);
    out.weight.push_back(mag.change[k].squaredNorm() / variance);
  }
  return out;
}

// Power on a grid of frequencies, each over the level about it.
struct LinePower {
  std::vector<double> f_hz, height;
};
LinePower line_power(const Ages& a, const std::vector<double>& x) {
  std::size_t n = 1;
  const double length = a.t.back() - a.t.front();
  while (double(n) < 2.0 * (length * a.rate_hz + 1.0)) n *= 2;
  std::vector<double> on_grid(n, 0.0);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const auto place = std::size_t(std::llround((a.t[k] - a.t.front()) * a.rate_hz));
    if (place < n) on_grid[place] += x[k];
  }
  const std::vector<double> all = PowerSpectrum()(on_grid);
  LinePower out;
  const double step = a.rate_hz / double(n);
  const auto first = std::size_t(kSlowestPatternHz / step);
  std::vector<double> power;
  for (std::size_t j = first; j <= n / 2; ++j) {
    out.f_hz.push_back(double(j) * step);
    power.push_back(all[j]);
  }
  // Levels of pieces, medians: a line is too narrow to raise them.
  const auto wide = std::max<std::size_t>(50, std::size_t(2.0 * kNeighbourhoodHz / step));
  for (std::size_t begin = 0; begin < power.size(); begin += wide) {
    const std::size_t end = std::min(begin + wide, power.size());
    const std::size_t from = end - begin < wide / 2 && end > wide ? end - wide : begin;
    std::vector<double> piece(power.begin() + std::ptrdiff_t(from),
                              power.begin() + std::ptrdiff_t(end));
    const double level = median(piece) / std::numbers::ln2;
    for (std::size_t j = begin; j < end; ++j)
      out.height.push_back(power[j] / std::max(level, 1e-300));
  }
  return out;
}

// By how many nats ages explain the samples, beside a lag of all of them.
struct Explained {
  double nats = 0.0, lag = 0.0;
  double height = 1.0;  // times as high they would explain the most
  double lower = 0.0;   // nats, where their height may be anything from nothing to their own
  double higher = 0.0;  // nats more, where they may be higher than that
};
struct AgeSums {
  double w = 0.0, y = 0.0, s = 0.0, ss = 0.0, sy = 0.0;
  void add(double age, double weight, double said) {
    w += weight;
    y += said;
    s += weight * age;
    ss += weight * age * age;
    sy += said * age;
  }
  Explained explained() const {
    if (!(w > 0.0)) return {};
    const double slope = sy - s * y / w, information = ss - s * s / w;
    Explained out{.nats = slope - 0.5 * information, .lag = (s - y) / w};
    out.height = slope / std::max(information, 1e-300);
    const double h = std::clamp(out.height, 0.0, 1.0);
    out.lower = h * slope - 0.5 * h * h * information;
    out.higher = out.height > 1.0 ? 0.5 * std::pow(out.height - 1.0, 2) * information : 0.0;
    return out;
  }
};
constexpr Measure kAsItIs{&Explained::nats};
Explained explained_by_clock(const Ages& a, double period_s, double share,
                             const std::vector<char>& chosen, double width = 1.0) {
  AgeSums sums;
  for (std::size_t k = 0; k < a.t.size(); ++k) {
    if (!chosen.empty() && !chosen[k]) continue;
    sums.add(left_of_sawtooth(a.t[k], period_s, share, width), a.weight[k], a.said[k]);
  }
  return sums.explained();
}

// The clocks' frequencies whose patterns are as fast as this: folded about the samples' rate.
template <typename F>
void for_each_fold(const Ages& a, double f_hz, const F& f) {
  for (int folds = 0; double(folds) * a.rate_hz < 1.0 / kShortestPeriod; ++folds) {
    for (const double hz : {folds * a.rate_hz + f_hz, folds * a.rate_hz - f_hz}) {
      if (hz >= 1.0 / kLongestPeriod && hz <= 1.0 / kShortestPeriod) f(hz);
    }
  }
}

struct Clock {
  double hz = 0.0, share = 0.0, nats = -1e300;
  double p_value = 1.0;  // of all that were looked at
  double needed = 0.0;   // nats by which a fit must be better with it; 0: the samples show it
};

// About a clock's frequency: what explains the most, by ever finer steps in frequency and share.
Clock refined(const Ages& a, double hz, const std::vector<char>& chosen,
              const Measure& measure = kAsItIs) {
  const double middle = 0.5 * (a.t.front() + a.t.back());
  const double length = a.t.back() - a.t.front();
  // Steps of the share are about the middle, so that the frequency turns nothing there.
  Clock best{.hz = hz};
  double at_middle = 0.0;
  const auto take = [&](double f, double phase) {
    const double share = phase - f * middle;
    const double nats =
        explained_by_clock(a, 1.0 / f, share - std::floor(share), chosen, measure.width).*
        measure.nats;
    if (nats <= best.nats) return;
    best = {.hz = f, .share = share - std::floor(share), .nats = nats};
    at_middle = phase;
  };
  constexpr int kShares = 24;
  for (int i = 0; i < kShares; ++i) take(hz, double(i) / kShares);
  double df = 0.5 / length, dp = 0.5 / kShares;
  for (int round = 0; round < 9; ++round, df *= 0.6, dp *= 0.6) {
    const double f = best.hz, phase = at_middle;
    for (const int i : {-1, 1}) {
      take(f + i * df, phase);
      take(f, phase + i * dp);
    }
  }
  return best;
}

// The likelihood of a sawtooth is jagged, since its jumps pass one sample after the other. So the
// neighbours of a clock that was found are tried on ever finer grids, in period and share together.
// (One sample in a hundred on the wrong side of a jump would look like outliers.)
void polish(const Ages& a, Clock& clock, const Measure& measure = kAsItIs) {
  constexpr int kSteps = 5, kRounds = 4;  // to each side
  constexpr double kFirst = 0.02, kFiner = 0.3;
  const double middle = 0.5 * (a.t.front() + a.t.back());
  const double half = 0.5 * (a.t.back() - a.t.front());
  double reach = kFirst;  // turns, in the middle and, by the frequency, at the ends
  for (int round = 0; round < kRounds; ++round, reach *= kFiner) {
    const Clock from = clock;
    for (int i = -kSteps; i <= kSteps; ++i) {
      const double hz = from.hz + reach * i / kSteps / half;
      for (int j = -kSteps; j <= kSteps; ++j) {
        const double turned = from.share - (hz - from.hz) * middle + reach * j / kSteps;
        const double share = turned - std::floor(turned);
        const double nats = explained_by_clock(a, 1.0 / hz, share, {}, measure.width).*measure.nats;
        if (nats <= clock.nats) continue;
        clock.hz = hz;
        clock.share = share;
        clock.nats = nats;
      }
    }
  }
}

constexpr int kPhases = 20;

// The first n samples by the phase of a pattern.
struct Phases {
  std::array<double, kPhases> w{}, said{}, across{};
};
Phases phases_of(const Ages& a, double f_hz, std::size_t n) {
  Phases out;
  for (std::size_t k = 0; k < n; ++k) {
    const double turns = f_hz * (a.t[k] - a.t.front());
    const auto bin = std::size_t((turns - std::floor(turns)) * kPhases) % kPhases;
    out.w[bin] += a.weight[k];
    out.said[bin] += a.said[k];
    out.across[bin] += a.across[k];
  }
  return out;
}

// What ages that are any function of the phase explain beside a lag of all.
double explained_by_phases(const Phases& phases, const std::array<double, kPhases>& y) {
  double nats = 0.0, all_w = 0.0, all_y = 0.0;
  for (std::size_t i = 0; i < kPhases; ++i) {
    if (!(phases.w[i] > 0.0)) continue;
    nats += 0.5 * y[i] * y[i] / phases.w[i];
    all_w += phases.w[i];
    all_y += y[i];
  }
  return all_w > 0.0 ? nats - 0.5 * all_y * all_y / all_w : 0.0;
}

// What the samples say of ages that are any function of a clock's phase, in steps.
struct Pattern {
  double nats = 0.0, reach_s = 0.0;  // reach: half of what is between the oldest and the newest
};
Pattern pattern_of(const Ages& a, double period_s) {
  const Phases phases = phases_of(a, 1.0 / period_s, a.t.size());
  double oldest = -1e300, newest = 1e300;
  for (std::size_t i = 0; i < kPhases; ++i) {
    if (!(phases.w[i] > 0.0)) continue;
    oldest = std::max(oldest, phases.said[i] / phases.w[i]);
    newest = std::min(newest, phases.said[i] / phases.w[i]);
  }
  return {explained_by_phases(phases, phases.said), std::max(0.0, 0.5 * (oldest - newest))};
}

// The clock whose pattern has the highest line.
Clock clock_of_line(const Ages& a, double level) {
  const LinePower along = line_power(a, a.said);
  if (along.height.empty()) return {};
  const auto best = std::ranges::max_element(along.height) - along.height.begin();
  const double height = along.height[std::size_t(best)], f_hz = along.f_hz[std::size_t(best)];
  const double p_value =
      std::min(1.0, double(along.height.size()) * std::exp(-std::min(height, kMostNats)));
  if (p_value > level) return {};
  // What is as high across the change is no matter of times.
  const LinePower across = line_power(a, a.across);
  for (std::size_t j = 0; j < across.height.size(); ++j) {
    const bool there = std::abs(across.f_hz[j] - f_hz) < 0.5;
    if (there && across.height[j] > kMostAcross * height) return {};
  }
  Clock clock;
  for_each_fold(a, f_hz, [&](double hz) {
    const Clock c = refined(a, hz, {});
    if (c.nats > clock.nats) clock = c;
  });
  clock.p_value = p_value;
  return clock;
}

// The same of a sawtooth of any height up to this one, the best of its shares.
double explained_by_sawtooth(const Phases& phases, double height, bool rises) {
  double best = 0.0;
  for (int j = 0; j < kPhases; ++j) {
    AgeSums sums;
    for (int i = 0; i < kPhases; ++i) {
      const int turned = rises ? i + j : j - i - 1 + kPhases;
      sums.add(height * (turned % kPhases + 0.5) / kPhases, phases.w[std::size_t(i)],
               phases.said[std::size_t(i)]);
    }
    best = std::max(best, sums.explained().lower);
  }
  return best;
}

// A clock of the recording's first seconds on to the whole, which knows its frequency so much
// better.
Clock grown(const Ages& a, double hz, double seconds, const Measure& measure) {
  for (;; seconds *= 2.0) {
    std::vector<char> chosen;
    for (const double t : a.t) chosen.push_back(t - a.t.front() <= seconds ? 1 : 0);
    const Clock clock = refined(a, hz, chosen, measure);
    if (seconds >= a.t.back() - a.t.front()) return clock;
    hz = clock.hz;
  }
}

// Where the two clocks nearly agree, the pattern is as slow as the hand's motion and the model's
// errors are, and the attitudes have taken a part of it. Not a line tells it there, but a sawtooth
// that is no higher than the clock's period, at every frequency: the clocks that fold to the best
// one, the slowest first. What it explains counts in units of what the model's errors make of it,
// the median over all frequencies.
std::vector<Clock> slow_clocks(const Ages& a, double level) {
  std::size_t n = a.t.size();
  while (a.t[n - 1] - a.t.front() > kLongestSearch) --n;
  const double length = a.t[n - 1] - a.t.front();
  double nats = 0.0, f_hz = 0.0, tried = 0.0;
  bool rises = false;
  std::vector<double> patterns;
  for (double f = kFewestTeeth / length; f < kSlowestPatternHz; f += 0.5 / length) {
    const Phases phases = phases_of(a, f, n);
    patterns.push_back(explained_by_phases(phases, phases.said));
    for (const bool rising : {false, true}) {
      const double of_this = explained_by_sawtooth(phases, 1.0 / a.rate_hz, rising);
      tried += kPhases;
      if (of_this <= nats) continue;
      nats = of_this;
      f_hz = f;
      rises = rising;
    }
  }
  if (patterns.size() < 2) return {};
  const double unit = std::max(1.0, median(std::move(patterns)) / (0.5 * (kPhases - 1)));
  const double p_value = std::min(1.0, tried * std::exp(-std::min(nats / unit, kMostNats)));
  if (p_value > level) return {};
  const Phases phases = phases_of(a, f_hz, n);
  if (explained_by_phases(phases, phases.across) > kMostAcross * nats) return {};
  // Attitudes may have taken the pattern's first lines, so that a higher one seems to be the first.
  std::vector<Clock> out;
  for (int harmonic = 1; harmonic <= kMostHarmonics; ++harmonic) {
    const double line_hz = f_hz / harmonic;
    if (line_hz < kFewestTeeth / length) break;
    const Measure measure{&Explained::lower, 1.0 / harmonic};
    for (int folds = 1; folds <= (harmonic > kFoldedOften ? 1 : kMostFolds); ++folds) {
      const double hz = folds * a.rate_hz + (rises ? line_hz : -line_hz);
      if (hz < 1.0 / kLongestPeriod || hz > 1.0 / kShortestPeriod) continue;
      Clock clock = grown(a, hz, length, measure);
      polish(a, clock, measure);
      const Explained e = explained_by_clock(a, 1.0 / clock.hz, clock.share, {}, measure.width);
      if (e.higher > -unit * std::log(level)) break;  // than a clock of this period reads
      clock.p_value = p_value;
      clock.needed = unit * (std::log(tried) - std::log(level));
      out.push_back(clock);
    }
  }
  return out;
}

// Every other ten seconds.
std::vector<char> stretches_of(const Ages& a, bool odd) {
  std::vector<char> out;
  for (const double t : a.t) {
    out.push_back((long((t - a.t.front()) / kStretch) % 2 != 0) == odd ? 1 : 0);
  }
  return out;
}

// Of period and share, from the curvature of what they explain: the ages' weights and slopes. Jumps
// of the sawtooth tell more, so these are on the safe side.
void put_sigmas(const Ages& a, OwnClock& clock) {
  const double T = clock.period_s, middle = 0.5 * (a.t.front() + a.t.back());
  double w = 0.0, turned = 0.0;
  for (std::size_t k = 0; k < a.t.size(); ++k) {
    w += a.weight[k];
    turned += a.weight[k] * std::pow((a.t[k] - middle) / T, 2);
  }
  // A share more makes all ages older but for what jumps: 1 / sqrt(12) of a period each.
  const double of_jump = 1.0 / std::sqrt(12.0);
  clock.share_sigma = 1.0 / std::max(std::sqrt(w) * T * of_jump, 1e-12);
  clock.period_sigma_s = 1.0 / std::max(std::sqrt(turned) * of_jump, 1e-12);
  clock.share_sigma = std::hypot(clock.share_sigma, clock.period_sigma_s * middle / (T * T));
}

OwnClock own_clock_of(const Ages& a, const Clock& clock) {
  OwnClock out{.period_s = 1.0 / clock.hz, .share = clock.share};
  out.pattern_s = 1.0 / std::abs(clock.hz - a.rate_hz * std::round(clock.hz / a.rate_hz));
  out.reach_s = out.period_s;
  out.p_value = clock.p_value;
  out.needed_nats = clock.needed;
  put_sigmas(a, out);
  return out;
}

// Empty where there are too few samples, or nothing tells how fast the reading changes.
std::optional<Ages> enough_ages(const SampleResiduals& mag) {
  if (mag.t.size() < kFewestForClock || mag.change.size() != mag.t.size()) return std::nullopt;
  Ages a = ages_of(mag);
  if (a.t.size() < kFewestForClock || !(a.rate_hz > 0.0)) return std::nullopt;
  return a;
}

// The clock that a line shows, if the samples have one.
std::optional<OwnClock> own_clock_of_line(const Ages& a, double level) {
  Clock clock = clock_of_line(a, level);
  if (!(clock.nats > -std::log(level))) return std::nullopt;
  polish(a, clock);
  OwnClock out = own_clock_of(a, clock);
  const Pattern pattern = pattern_of(a, out.period_s);
  const double beyond = 2.0 * (pattern.nats - clock.nats);
  out.held = !(beyond > 0.0) || chi_square_tail(beyond, kPhases - 3) > level;
  if (!out.held) out.reach_s = pattern.reach_s;
  // No sample is older than the pattern is long: something else has this line.
  if (!out.held && out.reach_s > out.pattern_s) return std::nullopt;
  for (const bool odd : {false, true}) {
    const Clock fitted = refined(a, clock.hz, stretches_of(a, odd));
    out.nll_before +=
        explained_by_clock(a, 1.0 / fitted.hz, fitted.share, stretches_of(a, !odd)).nats;
  }
  return out.nll_before > 1.0 ? std::optional(out) : std::nullopt;
}

}  // namespace

std::vector<OwnClock> find_own_clocks(const SampleResiduals& mag, double level) {
  const std::optional<Ages> a = enough_ages(mag);
  if (!a) return {};
  std::vector<OwnClock> out;
  if (const auto of_line = own_clock_of_line(*a, level)) out.push_back(*of_line);
  for (const Clock& clock : slow_clocks(*a, level)) out.push_back(own_clock_of(*a, clock));
  return out;
}

std::optional<OwnClock> find_own_clock(const SampleResiduals& mag, double level) {
  const std::optional<Ages> a = enough_ages(mag);
  return a ? own_clock_of_line(*a, level) : std::nullopt;
}

OwnClock told_anew(const OwnClock& clock, SampleResiduals mag) {
  for (std::size_t k = 0; k < mag.t.size() && mag.change.size() == mag.t.size(); ++k) {
    mag.residual[k] -= sawtooth(mag.t[k], clock.period_s, clock.share) * mag.change[k];
  }
  const Ages a = ages_of(mag);
  Clock fitted = refined(a, 1.0 / clock.period_s, {});
  polish(a, fitted);
  OwnClock out = clock;
  out.period_s = 1.0 / fitted.hz;
  out.share = fitted.share;
  out.needed_nats = 0.0;
  put_sigmas(a, out);
  return out;
}

double pattern_left(const OwnClock& clock, const SampleResiduals& mag) {
  return pattern_of(ages_of(mag), clock.period_s).nats - 0.5 * (kPhases - 1);
}

bool leaves_no_pattern(const OwnClock& clock, const SampleResiduals& mag, double level) {
  const double left = 2.0 * pattern_of(ages_of(mag), clock.period_s).nats;
  return chi_square_tail(std::max(0.0, left), kPhases - 1) > level;
}

void take_out_own_clock(double period_s, double share, SampleResiduals& mag) {
  const Ages a = ages_of(mag);
  const double lag = explained_by_clock(a, period_s, share, {}).lag;
  for (std::size_t k = 0; k < mag.t.size() && mag.change.size() == mag.t.size(); ++k) {
    mag.residual[k] += (sawtooth(mag.t[k], period_s, share) - lag) * mag.change[k];
  }
}

NoiseTest own_clock_test(const OwnClock& clock) {
  NoiseTest test;
  test.effect = "mag_own_clock";
  test.channel = Sensor::kMag;
  test.p_value = clock.p_value;
  test.statistic = -2.0 * std::log(std::max(clock.p_value, 1e-300));
  test.dof = 2;
  test.parameters = {{"T", clock.period_s, clock.period_sigma_s, "s"},
                     {"p", clock.share, clock.share_sigma, "1"}};
  test.nll_before = clock.nll_before;
  test.nll_after = clock.nll_after;
  const std::string repeats =
      fmt::format("in a pattern that repeats itself every {:.1f} ms", 1e3 * clock.pattern_s);
  test.sentence =
      clock.held
          ? fmt::format(
                "The magnetometer measures on a clock of its own and is read on another: "
                "what is read is up to {:.2f} ms older or newer than its time says, {} (as "
                "of a clock of {:.4f} +- {:.1g} ms).",
                1e3 * clock.reach_s, repeats, 1e3 * clock.period_s, 1e3 * clock.period_sigma_s)
          : fmt::format(
                "The magnetometer measures on a clock of its own and its samples are "
                "interpolated to another: they are up to {:.2f} ms older or newer than "
                "their times say, {}. The period of its clock is not known: interpolated "
                "samples have several that explain them alike (aliases), of which one is "
                "listed.",
                1e3 * clock.reach_s, repeats);
  return test;
}

}  // namespace magimu
