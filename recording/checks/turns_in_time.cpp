// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/turns_in_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "recording/data/times/time_unit.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

// 4000 deg/s, the widest range of any gyroscope in chips.
constexpr double kFastest = 4000.0 * M_PI / 180.0;
// A hand that calibrates turns faster than this at times.
constexpr double kSlowest = 0.05;  // rad/s
// How well directions tell the rate of a hand that swings.
constexpr double kNearUnit = 0.1;

struct TimeUnit {
  double seconds;
  const char* name;
};
constexpr TimeUnit kTimeUnits[] = {{3600.0, "hours"},
                                   {60.0, "minutes"},
                                   {1.0, "seconds"},
                                   {1e-1, "tenths of a second"},
                                   {1e-2, "hundredths of a second"},
                                   {1e-3, "milliseconds"},
                                   {1e-4, "tenths of a millisecond"},
                                   {1e-5, "hundredths of a millisecond"},
                                   {1e-6, "microseconds"},
                                   {1e-7, "tenths of a microsecond"},
                                   {1e-9, "nanoseconds"}};

// The rate that is exceeded in 3 % of the samples.
double fast_rate(const VectorSeries& gyr) {
  std::vector<double> rates;
  for (const Vector3& v : gyr.v) rates.push_back(v.norm());
  return quantile(std::move(rates), 0.97);
}

double median_interval(const VectorSeries& s) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < s.size(); ++k) intervals.push_back(s.t[k] - s.t[k - 1]);
  return median(std::move(intervals));
}

Issue time_issue(const std::string& problem, const std::string& remedy) {
  return {"time_unit", "gyr", -1, Severity::kFatal, 0.0, 0.0, problem, remedy};
}

}  // namespace

std::optional<Issue> time_unit_of_turns(const Recording& r, double gain, bool explained) {
  constexpr double kCounts = 1e-6;  // of a sample: the times count them
  const double fast = fast_rate(r.gyr), rate = gain * r.gyr.rate_hz();
  const bool impossible = fast / gain > kFastest;
  if ((explained && !impossible) || fast > kFastest || fast < kSlowest) return std::nullopt;
  if (rate * kMostInterval < 1.0 || rate * kLeastInterval > 1.0) return std::nullopt;
  const auto given = r.file_units.find("t");
  const double was = given == r.file_units.end() ? 1.0 : given->second, unit = was / gain;
  const std::string problem = fmt::format(
      "by its times the directions of the other sensors turn at {:.4g} times the rate that the "
      "gyroscope reads{}",
      1.0 / gain,
      impossible
          ? fmt::format(", {:.0f} deg/s, which no gyroscope measures", fast / gain * 180.0 / M_PI)
          : "");
  // The times are numbers of samples.
  if (std::abs(median_interval(r.gyr) / was - 1.0) < kCounts) {
    return time_issue(
        fmt::format("{}: the times count samples", problem),
        fmt::format("give the rate of the samples; --rate {0:.4g} would fit (in memory: divide the "
                    "times by it)",
                    rate));
  }
  const auto* const usual = std::ranges::min_element(
      kTimeUnits, {},
      [unit](const TimeUnit& candidate) { return std::abs(std::log(unit / candidate.seconds)); });
  if (std::abs(unit / usual->seconds - 1.0) > kNearUnit) {
    if (!impossible) return std::nullopt;
    return time_issue(fmt::format("{}: the times are in another unit than was thought", problem),
                      fmt::format("give the unit of time: --unit t={:.4g} would fit (one of it in "
                                  "s; in memory: multiply the times by {:.4g}), or the rate, "
                                  "--rate {:.4g}",
                                  unit, 1.0 / gain, rate));
  }
  return time_issue(fmt::format("{}: the times seem to be in {}", problem, usual->name),
                    fmt::format("give the unit of time: --unit t={:g} (in memory: multiply the "
                                "times by {:g})",
                                usual->seconds, usual->seconds / was));
}

}  // namespace magimu
