// SPDX-License-Identifier: BSD-3-Clause
// A gyroscope's unit: the directions of gravity and of the field turn as fast as the device.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>

#include "recording/checks/turn_regression.h"
#include "recording/checks/turns_in_time.h"
#include "recording/checks/unit_issues.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

constexpr double kDeg = M_PI / 180.0;
// Gain from which the range is wrong. Ranges differ by a factor of 2 at least, and this is halfway
// (as a factor). On real recordings the regression is off by up to 15 %.
constexpr double kWrongScale = M_SQRT2;
constexpr double kExplained =
    0.5;  // of the turns that the gyroscope explains: with less, its scale is not judged
// A gyroscope's gain is within this share of a named unit. The gain is measured by how directions
// turn, to a tenth in a hand that swings; units are 17 times apart and more.
constexpr double kNearRate = 0.1;
// Relative error of the gain, and the odds that whole numbers are counts of a converter (and that
// other numbers are in a unit).
constexpr double kRateSigma = 0.02, kOdds = 10.0;
// Counts per deg/s in data sheets (10: the file holds tenths of a degree).
// (16 a deg/s and 900 a rad/s: the BNO055's.)
constexpr double kGyrCounts[] = {
    10, 131, 65.5, 32.8, 16.4, 114.286, 57.143, 28.571, 14.286, 900 * M_PI / 180, 16};
constexpr double kSameCounts = 0.03;
constexpr double kSeveralSigmas = 3.0;  // of the gain: sensitivities within them are all named
// What ranges of a gyroscope differ by.
constexpr double kRangeFactors[] = {2.0, 4.0, 8.0, 0.5, 0.25, 0.125};

// The series without clipped samples: those at an extreme that many samples share. A clipped rate
// does not tell the size of the rate.
VectorSeries without_clipped(const VectorSeries& s) {
  constexpr std::size_t kShared = 10;  // samples: noise does not make so many equal extremes
  Vector3 low = s.v.front(), high = low;
  for (const Vector3& v : s.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::array<std::size_t, 3> at_low{}, at_high{};
  for (const Vector3& v : s.v) {
    for (int i = 0; i < 3; ++i) {
      at_low[std::size_t(i)] += v[i] == low[i] ? 1 : 0;
      at_high[std::size_t(i)] += v[i] == high[i] ? 1 : 0;
    }
  }
  VectorSeries out;
  for (std::size_t k = 0; k < s.size(); ++k) {
    bool clipped = false;
    for (int i = 0; i < 3; ++i) {
      clipped = clipped || (at_low[std::size_t(i)] > kShared && s.v[k][i] == low[i]) ||
                (at_high[std::size_t(i)] > kShared && s.v[k][i] == high[i]);
    }
    if (!clipped) out.push_back(s.t[k], s.v[k]);
  }
  return out;
}

// The gyroscope's reading over the true rate, as the directions of the other sensors show it, and
// its standard error.
struct GyroscopeGain {
  double gain, sigma;
};

// By accelerometer and magnetometer, as far as each tells.
std::vector<GyroscopeGain> gains_of(const Recording& r) {
  std::vector<GyroscopeGain> seen;
  const VectorSeries gyr = without_clipped(r.gyr);
  const auto look = [&](const VectorSeries& directions, bool offset_unknown) {
    if (directions.size() < kFewestToJudge) return;
    const auto found = regress_turns(gyr, directions, offset_unknown);
    if (!found || found->explained < kExplained || found->scale <= 0.0) return;
    const double relative = found->sigma / found->scale;
    seen.push_back({1.0 / found->scale, relative / found->scale});
  };
  look(r.acc, false);
  if (!r.mag.empty()) look(r.mag.front(), true);
  return seen;
}

const GyroscopeGain& best_known(const std::vector<GyroscopeGain>& seen) {
  return *std::ranges::min_element(seen, {},
                                   [](const GyroscopeGain& s) { return s.sigma / s.gain; });
}

// Gains of two parts of a recording that differ, with the times of the parts, s.
struct GainChange {
  struct Part {
    double begin, end;
    GyroscopeGain seen;
  };
  Part earlier, later;
};

// A unit is that of the whole file. A gain that becomes another one is a fault of the sensor, or
// its range was switched.
std::optional<GainChange> change_meanwhile(const Recording& r) {
  constexpr std::size_t kQuarters = 4;
  std::vector<GainChange::Part> parts;
  // Of the samples, not of the clock, which may jump.
  const std::vector<double>& t = r.gyr.t;
  for (std::size_t i = 0; i < kQuarters; ++i) {
    const double from = t[t.size() * i / kQuarters];
    const double to = t[std::min(t.size() * (i + 1) / kQuarters, t.size() - 1)];
    const Recording part = slice(r, from, to);
    if (part.gyr.size() < kFewestToJudge) continue;
    const std::vector<GyroscopeGain> seen = gains_of(part);
    if (!seen.empty()) parts.push_back({from, to, best_known(seen)});
  }
  if (parts.size() < 2) return std::nullopt;
  auto [a, b] =
      std::ranges::minmax_element(parts, {}, [](const auto& part) { return part.seen.gain; });
  const double change = std::log(b->seen.gain / a->seen.gain);
  const double sigma = std::hypot(a->seen.sigma / a->seen.gain, b->seen.sigma / b->seen.gain);
  if (change < std::log(kWrongScale) || change < kScaleSigmas * sigma) return std::nullopt;
  if (a > b) std::swap(a, b);
  return GainChange{*a, *b};
}

Issue gain_change_issue(const GainChange& c) {
  return {"gain_changes",
          "gyr",
          -1,
          Severity::kFatal,
          0.0,
          0.0,
          fmt::format("from {:.1f} to {:.1f} s the gyroscope reads {:.2f} times the rate at which "
                      "the other sensors' directions turn, and from {:.1f} to {:.1f} s {:.2f} "
                      "times: its range was switched meanwhile, or it failed",
                      c.earlier.begin, c.earlier.end, c.earlier.seen.gain, c.later.begin,
                      c.later.end, c.later.seen.gain),
          "cut the recording where it changed, and calibrate the parts one by one"};
}

// Empty if the gain is in order, or not known.
std::optional<GyroscopeGain> gyroscope_gain(const Recording& r) {
  const std::vector<GyroscopeGain> seen = gains_of(r);
  if (seen.empty()) return std::nullopt;
  // If accelerometer and magnetometer disagree, one of them has a fault; then nothing is said of
  // the gyroscope.
  for (const GyroscopeGain& s : seen) {
    const double size = std::abs(std::log(s.gain));
    if (size < std::log(kWrongScale) || size < kScaleSigmas * s.sigma / s.gain) return std::nullopt;
    if (std::abs(std::log(s.gain / seen.front().gain)) > std::log(kWrongScale)) return std::nullopt;
  }
  return best_known(seen);
}

// counts: of the file a deg/s, known to this relative sigma. Several sensitivities may be as near.
Issue counts_issue(const Recording& r, const std::string& turns, double counts, double sigma) {
  // Some are two per cent apart (16 and 16.4): what was measured tells them apart, or does not.
  const double same = std::max(kRateSigma, kSeveralSigmas * sigma);
  std::vector<double> known;
  for (const double k : kGyrCounts) {
    if (std::abs(counts / k - 1.0) < same) known.push_back(k);
  }
  if (known.empty()) known.push_back(snapped(kGyrCounts, counts, kSameCounts));
  std::ranges::sort(known, {}, [counts](double k) { return std::abs(std::log(counts / k)); });
  std::vector<std::string> per_degree, units;
  for (const double k : known) {
    per_degree.push_back(fmt::format("{:.4g}", k));
    units.push_back(fmt::format("{:.6g} (one count in rad/s)", kDeg / k));
  }
  return unit_issue(r, "gyr", "gyr",
                    fmt::format("{}; perhaps these are counts of the converter, {} a deg/s", turns,
                                fmt::join(per_degree, " or ")),
                    fmt::format("{}", fmt::join(units, " or --unit gyr=")));
}

}  // namespace

std::vector<Issue> check_gyr_unit(const Recording& r) {
  const std::optional<GyroscopeGain> seen = gyroscope_gain(r);
  if (!seen) return {};
  if (const auto change = change_meanwhile(r)) return {gain_change_issue(*change)};
  const double gain = seen->gain;
  const double given = file_unit(r, "gyr"), unit = given / gain;  // that makes it the true rate
  const std::string turns = fmt::format(
      "the gyroscope reads {:.4g} +- {:.2g} times the rate at which the other sensors' directions "
      "turn",
      gain, seen->sigma);
  const std::string name = unit_text("gyr", unit, kNearRate);
  const double of_converter = nearest(kGyrCounts, kDeg / unit);
  const auto off = [&](double a, double b) { return std::pow(std::log(a / b), 2); };
  // mrad/s and 16.4 counts per deg/s differ by 6 % only. The nearer one is taken, with odds for
  // whole numbers to be counts.
  const double odds = 2.0 * kRateSigma * kRateSigma * std::log(kOdds);
  const bool named = std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                     off(unit, *unit_in_ours("gyr", name)) <
                         off(kDeg / unit, of_converter) + (is_whole(r.gyr, given) ? -odds : odds);
  const bool other_unit = named && std::abs(unit / given - 1.0) > kNear;
  const bool other_range = std::ranges::any_of(
      kRangeFactors, [gain](double range) { return std::abs(gain / range - 1.0) <= kNear; });
  const bool counts_known = std::abs(kDeg / unit / of_converter - 1.0) < kSameCounts;
  if (auto time = time_unit_of_turns(
          r, gain, other_unit || other_range || counts_known || is_whole(r.gyr, given))) {
    return {*std::move(time)};
  }
  if (other_unit) {
    return {
        unit_issue(r, "gyr", "gyr", fmt::format("{}: it seems to be in {}", turns, name), name)};
  }
  for (const double range : kRangeFactors) {
    if (std::abs(gain / range - 1.0) > kNear) continue;
    return {unit_issue(
        r, "gyr", "gyr",
        fmt::format(
            "{}: its range was set to {} of what the driver takes it for, or the times of "
            "the samples are {} as far apart as they were",
            turns,
            range > 1.0 ? fmt::format("1/{:.0f}", range) : fmt::format("{:.0f} times", 1.0 / range),
            range > 1.0 ? fmt::format("{:.0f} times", range)
                        : fmt::format("1/{:.0f}", 1.0 / range)),
        unit_text("gyr", given / range))};
  }
  return {counts_issue(r, turns, kDeg / unit, seen->sigma / gain)};
}

}  // namespace magimu
