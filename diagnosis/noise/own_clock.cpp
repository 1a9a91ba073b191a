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
constexpr double kSlowestPatternHz = 2.0;  // below, a hand's motion and the model's errors are
constexpr double kShortestPeriod = 1e-3, kLongestPeriod = 0.05;  // s
constexpr double kNeighbourhoodHz = 2.0;  // whose median is the level of the noise, to each side
constexpr double kMostAcross = 0.25;      // of the line's height along the change
constexpr double kStretch = 10.0;         // s

double sawtooth(double t, double period_s, double share) {
  const double turns = t / period_s + share;
  return period_s * (turns - std::floor(turns));
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

// By how many nats a sawtooth explains the samples chosen, beside a lag of all of them.
struct Explained {
  double nats = 0.0, lag = 0.0;
};
Explained explained_by_clock(const Ages& a, double period_s, double share,
                             const std::vector<char>& chosen) {
  double w = 0.0, y = 0.0, s = 0.0, ss = 0.0, sy = 0.0;
  for (std::size_t k = 0; k < a.t.size(); ++k) {
    if (!chosen.empty() && !chosen[k]) continue;
    const double age = sawtooth(a.t[k], period_s, share);
    w += a.weight[k];
    y += a.said[k];
    s += a.weight[k] * age;
    ss += a.weight[k] * age * age;
    sy += a.said[k] * age;
  }
  if (!(w > 0.0)) return {};
  // age - lag in place of the best lag alone
  const double lag = (s - y) / w;
  const double with = sy - lag * y - 0.5 * (ss - 2.0 * lag * s + lag * lag * w);
  return {with - 0.5 * y * y / w, lag};
}

struct Clock {
  double hz = 0.0, share = 0.0, nats = -1e300;
};

// About a clock's frequency: what explains the most, by ever finer steps in frequency and share.
Clock refined(const Ages& a, double hz, const std::vector<char>& chosen) {
  const double middle = 0.5 * (a.t.front() + a.t.back());
  const double length = a.t.back() - a.t.front();
  // Steps of the share are about the middle, so that the frequency turns nothing there.
  Clock best{hz, 0.0, -1e300};
  double at_middle = 0.0;
  const auto take = [&](double f, double phase) {
    const double share = phase - f * middle;
    const double nats = explained_by_clock(a, 1.0 / f, share - std::floor(share), chosen).nats;
    if (nats <= best.nats) return;
    best = {f, share - std::floor(share), nats};
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
void polish(const Ages& a, Clock& clock) {
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
        const double nats = explained_by_clock(a, 1.0 / hz, share, {}).nats;
        if (nats > clock.nats) clock = {hz, share, nats};
      }
    }
  }
}

// The same for ages that are any function of the clock's phase, in steps.
struct Pattern {
  double nats = 0.0, reach_s = 0.0;  // reach: half of what is between the oldest and the newest
};
constexpr int kPhases = 20;
Pattern pattern_of(const Ages& a, double period_s) {
  std::array<double, kPhases> w{}, y{};
  for (std::size_t k = 0; k < a.t.size(); ++k) {
    const double turns = a.t[k] / period_s;
    const auto bin =
        std::min<std::size_t>(kPhases - 1, std::size_t((turns - std::floor(turns)) * kPhases));
    w[bin] += a.weight[k];
    y[bin] += a.said[k];
  }
  Pattern out;
  double all_w = 0.0, all_y = 0.0, oldest = -1e300, newest = 1e300;
  for (std::size_t i = 0; i < kPhases; ++i) {
    if (!(w[i] > 0.0)) continue;
    out.nats += 0.5 * y[i] * y[i] / w[i];
    all_w += w[i];
    all_y += y[i];
    oldest = std::max(oldest, y[i] / w[i]);
    newest = std::min(newest, y[i] / w[i]);
  }
  if (all_w > 0.0) out.nats -= 0.5 * all_y * all_y / all_w;
  out.reach_s = std::max(0.0, 0.5 * (oldest - newest));
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

}  // namespace

std::optional<OwnClock> find_own_clock(const SampleResiduals& mag, double level) {
  if (mag.t.size() < kFewestForClock || mag.change.size() != mag.t.size()) return std::nullopt;
  const Ages a = ages_of(mag);
  if (a.t.size() < kFewestForClock || !(a.rate_hz > 0.0)) return std::nullopt;
  const LinePower along = line_power(a, a.said);
  if (along.height.empty()) return std::nullopt;
  const auto best = std::ranges::max_element(along.height) - along.height.begin();
  const double height = along.height[std::size_t(best)], f_hz = along.f_hz[std::size_t(best)];
  OwnClock out;
  out.p_value = std::min(1.0, double(along.height.size()) * std::exp(-std::min(height, 690.0)));
  if (out.p_value > level) return std::nullopt;
  // What is as high across the change is no matter of times.
  const LinePower across = line_power(a, a.across);
  for (std::size_t j = 0; j < across.height.size(); ++j) {
    const bool there = std::abs(across.f_hz[j] - f_hz) < 0.5;
    if (there && across.height[j] > kMostAcross * height) return std::nullopt;
  }
  Clock clock;
  for (int folds = 0; double(folds) * a.rate_hz < 1.0 / kShortestPeriod; ++folds) {
    for (const double hz : {folds * a.rate_hz + f_hz, folds * a.rate_hz - f_hz}) {
      if (hz < 1.0 / kLongestPeriod || hz > 1.0 / kShortestPeriod) continue;
      const Clock c = refined(a, hz, {});
      if (c.nats > clock.nats) clock = c;
    }
  }
  if (!(clock.nats > -std::log(level))) return std::nullopt;
  polish(a, clock);
  const Pattern pattern = pattern_of(a, 1.0 / clock.hz);
  const double beyond = 2.0 * (pattern.nats - clock.nats);
  out.pattern_s = 1.0 / std::abs(clock.hz - a.rate_hz * std::round(clock.hz / a.rate_hz));
  out.held = !(beyond > 0.0) || chi_square_tail(beyond, kPhases - 3) > level;
  out.reach_s = out.held ? 1.0 / clock.hz : pattern.reach_s;
  // No sample is older than the pattern is long: something else has this line.
  if (!out.held && out.reach_s > out.pattern_s) return std::nullopt;
  out.period_s = 1.0 / clock.hz;
  out.share = clock.share;
  for (const bool odd : {false, true}) {
    const Clock fitted = refined(a, clock.hz, stretches_of(a, odd));
    out.nll_before +=
        explained_by_clock(a, 1.0 / fitted.hz, fitted.share, stretches_of(a, !odd)).nats;
  }
  put_sigmas(a, out);
  return out.nll_before > 1.0 ? std::optional(out) : std::nullopt;
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
