// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/times/time_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

// Seconds since 1970, of the years 2001 to 2049. In ms, us and ns these numbers are larger than
// those of any clock that counts since boot with the same intervals.
constexpr double kEpochBegin = 1e9, kEpochEnd = 2.5e9;
constexpr double kGaps = 0.01;              // of the intervals may be gaps
constexpr std::size_t kEnoughToCount = 20;  // intervals, before a column is taken for a counter
constexpr double kMostlyOne = 0.95;         // of a counter's steps; the others are lost samples

struct TimeUnit {
  const char* name;
  double seconds;
  const char* since = nullptr;  // of a calendar: when it begins
  double before_1970 = 0.0;     // s
};
constexpr TimeUnit kTimeUnits[] = {{"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}};
constexpr TimeUnit kTick{"1e-7", 1e-7};  // of Windows and .NET
constexpr TimeUnit kCalendars[] = {{"ms", 1e-3, "1970"},
                                   {"us", 1e-6, "1970"},
                                   {"ns", 1e-9, "1970"},
                                   {"ticks of 100 ns", 1e-7, "the year 1 (.NET)", 62135596800.0},
                                   {"ticks of 100 ns", 1e-7, "1601 (Windows)", 11644473600.0}};

bool is_usual(double interval) { return interval >= kLeastInterval && interval <= kMostInterval; }

// A date of our times with samples as often as an IMU's.
const TimeUnit* calendar_of(double first, double usual) {
  const auto* const found = std::ranges::find_if(kCalendars, [=](const TimeUnit& unit) {
    const double t = first * unit.seconds - unit.before_1970;
    return is_usual(usual * unit.seconds) && t > kEpochBegin && t < kEpochEnd;
  });
  return found == std::end(kCalendars) ? nullptr : found;
}

std::string hz_in(double usual, const TimeUnit& unit) {
  return fmt::format("{:.4g} Hz if it is in {}", 1.0 / (usual * unit.seconds), unit.name);
}

// Faster than any IMU in seconds: spreadsheets and MATLAB's datenum count days.
void too_fast(const std::string& column, double usual, const RowFailure& fail) {
  constexpr double kDay = 86400.0;
  fail(0,
       fmt::format("there is a row every {:.3g} of column {}: {:.4g} Hz if it is in s, {:.4g} Hz "
                   "if it is in days",
                   usual, column, 1.0 / usual, 1.0 / (kDay * usual)),
       fmt::format("give the unit of time: --unit t=s, --unit t={:.0f} for days, or another "
                   "number (one of it in s)",
                   kDay));
}

}  // namespace

double usual_row_interval(const RawRows& rows) {
  constexpr std::uint32_t kImu = RawRows::kAcc | RawRows::kGyr;
  const bool imu = std::ranges::any_of(rows.sensors, [](auto s) { return (s & kImu) != 0; });
  std::vector<double> d;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < rows.time.size(); ++k) {
    if (imu && (rows.sensors[k] & kImu) == 0) continue;
    if (rows.time[k] > last) d.push_back(rows.time[k] - last);
    last = rows.time[k];
  }
  if (d.empty()) return 0.0;
  if (d.size() > 1) {
    const std::size_t gaps = std::max<std::size_t>(1, std::size_t(kGaps * double(d.size())));
    std::ranges::nth_element(d, d.end() - std::ptrdiff_t(gaps));
    d.resize(d.size() - gaps);
  }
  return std::accumulate(d.begin(), d.end(), 0.0) / double(d.size());
}

double unit_beside_header(const RawRows& rows, const RowTimesOptions& options, double usual,
                          const RowFailure& fail, std::vector<std::string>& notes) {
  const std::string column = quoted_text(options.column);
  const bool by_header = !options.unit_in_header.empty() && rows.time.size() > kEnoughToCount;
  if (!by_header || usual == 0.0) return 1.0;
  if (usual >= kLeastInterval && usual <= kMostInterval) return 1.0;
  const double step = usual / options.unit;  // in the file
  std::vector<TimeUnit> possible;
  for (const TimeUnit& unit : {TimeUnit{"s", 1.0}, kTimeUnits[0], kTimeUnits[1], kTimeUnits[2]}) {
    const double d = step * unit.seconds;
    if (d >= kLeastInterval && d <= kMostInterval) possible.push_back(unit);
  }
  if (possible.empty()) return 1.0;
  const std::string said = fmt::format("{} {}: there would be a row every {:.3g} s", column,
                                       options.unit_in_header, usual);
  if (options.unit_of_name && possible.size() == 1) {
    notes.push_back(fmt::format("column {}; it is read as {}, {:.4g} Hz", said, possible[0].name,
                                1.0 / (step * possible[0].seconds)));
    return possible[0].seconds / options.unit;
  }
  std::vector<std::string> seem, remedies;
  for (const TimeUnit& unit : possible) {
    seem.push_back(fmt::format("{} ({:.4g} Hz)", unit.name, 1.0 / (step * unit.seconds)));
    remedies.push_back(fmt::format("--unit t={}", unit.name));
  }
  fail(0, fmt::format("column {}; it seems to be in {}", said, fmt::join(seem, " or ")),
       fmt::format("give the unit of time, {}", fmt::join(remedies, " or ")));
  return 1.0;
}

double unit_of_times(const RawRows& rows, const RowTimesOptions& options, double usual,
                     const RowFailure& fail, std::vector<std::string>& notes) {
  const std::string column = quoted_text(options.column);
  if (counts_samples(rows)) {
    fail(0, fmt::format("column {} counts samples (0, 1, 2, ...): it is not a time", column),
         "give the rate, --rate HZ; or the unit, --unit t=ms, if there is a sample every "
         "millisecond");
  }
  if (usual > 0.0 && usual < kLeastInterval && rows.time.size() > kEnoughToCount) {
    too_fast(column, usual, fail);
  }
  if (usual <= kMostInterval) return 1.0;
  const TimeUnit* const calendar = calendar_of(rows.time.front(), usual);
  std::vector<TimeUnit> possible;
  if (calendar != nullptr) {
    possible = {*calendar};
  } else {
    std::ranges::copy_if(kTimeUnits, std::back_inserter(possible),
                         [=](const TimeUnit& unit) { return is_usual(usual * unit.seconds); });
    const bool ticks = options.column.find("ick") != std::string::npos;
    if (ticks && is_usual(usual * kTick.seconds)) possible.push_back(kTick);
  }
  const std::string pace = fmt::format("there is a row every {:.6g} of column {}", usual, column);
  if (possible.empty()) {
    fail(0, pace + ", which is no time of an IMU's samples in s, ms, us or ns",
         "give the unit of time, --unit t=NUMBER (one of it in s), or the rate, --rate HZ");
  }
  if (possible.size() > 1) {
    std::vector<std::string> rates, remedies;
    for (const TimeUnit& unit : possible) {
      rates.push_back(hz_in(usual, unit));
      remedies.push_back(fmt::format("--unit t={}", unit.name));
    }
    fail(0, fmt::format("{}: {}", pace, fmt::join(rates, ", ")),
         fmt::format("give the unit of time, {}", fmt::join(remedies, " or ")));
  }
  const TimeUnit& unit = possible.front();
  notes.push_back(fmt::format("column {} is read as {}{}: {}, {:.4g} Hz", column, unit.name,
                              unit.since != nullptr ? fmt::format(" since {}", unit.since) : "",
                              pace, 1.0 / (usual * unit.seconds)));
  return unit.seconds;
}

bool counts_samples(const RawRows& rows) {
  const std::vector<double>& t = rows.time;
  std::size_t ones = 0, steps = 0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (t[k] != std::floor(t[k])) return false;
    if (k == 0 || !(t[k] > t[k - 1])) continue;
    ++steps;
    ones += t[k] - t[k - 1] == 1.0 ? 1 : 0;
  }
  return steps >= kEnoughToCount && double(ones) >= kMostlyOne * double(steps) &&
         !many_of_one_time(rows);
}

bool many_of_one_time(const RawRows& rows) {
  std::size_t same = 0;
  for (std::size_t k = 1; k < rows.time.size(); ++k) {
    const bool shares = (rows.fresh(k) & rows.sensors[k - 1] & RawRows::kVectors) != 0;
    same += shares && rows.time[k] == rows.time[k - 1] ? 1 : 0;
  }
  return double(same) > kManyOfOneTime * double(rows.time.size());
}

}  // namespace magimu
