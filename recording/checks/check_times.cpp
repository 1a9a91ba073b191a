// SPDX-License-Identifier: BSD-3-Clause
// Checks of time stamps: order, gaps, jitter, common span, unit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "recording/checks/quality_checks.h"
#include "recording/data/units.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kGapIntervals = 4.0;  // usual intervals without a sample
constexpr double kGapSeconds =
    0.03;                         // s: shorter ones are no gaps, as a hand hardly moves meanwhile
constexpr double kLongGap = 0.3;  // s; a turning hand is then anywhere
constexpr double kJitter = 0.5;   // of the usual interval: 5 % of all intervals are off by more
constexpr double kInHeaps =
    0.5;  // of the mean interval: samples come in heaps if most intervals are shorter
constexpr std::size_t kShown = 3;  // places that a sentence names
constexpr double kFastest = 2e-5;  // s: no IMU has shorter intervals
// Intervals, in the unit of the file, from which on its times seem to be in us, or in ns; below, in
// ms.
constexpr double kInMicroseconds = 300.0, kInNanoseconds = 3e5;
constexpr double kCommonSpan = 0.9;  // of the time that all sensors cover together

std::vector<double> intervals(const VectorSeries& series) {
  std::vector<double> out;
  for (std::size_t k = 0; k + 1 < series.size(); ++k) {
    out.push_back(series.t[k + 1] - series.t[k]);
  }
  return out;
}

struct Gap {
  double begin, end;
};

// "3.21-3.55 s, 7.10-7.30 s and 4 more"
std::string places(const std::vector<Gap>& gaps) {
  std::string out;
  for (std::size_t i = 0; i < gaps.size() && i < kShown; ++i) {
    out += fmt::format("{}{:.2f}-{:.2f} s", i > 0 ? ", " : "", gaps[i].begin, gaps[i].end);
  }
  if (gaps.size() > kShown) out += fmt::format(" and {} more", gaps.size() - kShown);
  return out;
}

// Whether samples were there and were set aside, which another issue says.
bool left_by(const std::vector<SetAside>& set_aside, const std::string& sensor, const Gap& gap) {
  return std::ranges::any_of(set_aside, [&](const SetAside& s) {
    return s.sensor == sensor && s.begin_s < gap.end && s.end_s > gap.begin;
  });
}

Issue gap_issue(const NamedSeries& sensor, std::vector<Gap> gaps, double usual) {
  std::ranges::stable_sort(
      gaps, [](const Gap& a, const Gap& b) { return a.end - a.begin > b.end - b.begin; });
  double lost = 0.0;
  for (const Gap& gap : gaps) lost += gap.end - gap.begin - usual;
  const double longest = gaps.front().end - gaps.front().begin;
  const std::string where = gaps.size() == 1 ? "a gap at " + places(gaps)
                                             : fmt::format("{} gaps, at {} (the longest first)",
                                                           gaps.size(), places(gaps));
  Issue issue{
      "gap",
      sensor.name,
      -1,
      Severity::kCaution,
      gaps.front().begin,
      gaps.front().end,
      fmt::format("{} has {}: about {:.0f} samples are missing", sensor.name, where, lost / usual),
      "slow the logger down or write to a faster medium"};
  if (sensor.name == "gyr" && longest > kLongGap) {
    issue.remedy = fmt::format(
        "how the sensor turned in the longest ({:.2f} s) is lost; after a gap that the motion does "
        "not let bridge a new part of the recording begins, with an attitude of its own",
        longest);
  } else if (sensor.is_mag()) {
    issue.severity = Severity::kNote;
    issue.remedy = "no harm beyond the samples that are missing";
  }
  return issue;
}

// The share of the usual interval by which one interval in twenty differs from it, or more.
double spread_of(std::vector<double> dt, double usual, double allowed) {
  for (double& d : dt) d = std::max(0.0, std::abs(d - usual) - allowed) / usual;
  return quantile(std::move(dt), 0.95);
}

// A slower sensor whose readings are written in the rows of a faster, steady one: in the first row
// after each measurement. Its intervals are then right to one row of the faster sensor.
std::optional<Issue> written_in_rows(const NamedSeries& sensor, const std::vector<double>& dt,
                                     const VectorSeries& rows) {
  constexpr double kSlower = 1.1;     // rows an interval
  constexpr double kSameTime = 1e-3;  // of a row
  constexpr double kOneRow = 1.05;    // rows are steady to some per cent
  const std::vector<double> between = intervals(rows);
  if (sensor.series == &rows || between.size() < kFewestToJudge) return std::nullopt;
  const double row = median(std::vector<double>(between));
  const double usual = median(std::vector<double>(dt));
  double sum = 0.0, count = 0.0;
  for (const double d : dt) {
    if (d > kGapIntervals * usual) continue;
    sum += d;
    ++count;
  }
  const double own = sum / std::max(count, 1.0);
  if (own < kSlower * row || spread_of(between, row, 0.0) > kJitter) return std::nullopt;
  for (const double t : sensor.series->t) {
    const auto next = std::ranges::lower_bound(rows.t, t - kSameTime * row);
    const bool in_a_row = next != rows.t.end() && *next < t + kSameTime * row;
    const bool inside = t > rows.t.front() && t < rows.t.back();
    if (inside && !in_a_row) return std::nullopt;
  }
  if (spread_of(dt, own, kOneRow * row) > kJitter) return std::nullopt;
  return Issue{"jitter",
               sensor.name,
               -1,
               Severity::kNote,
               0.0,
               0.0,
               fmt::format("the times of {} are those of the rows that it is written in, one every "
                           "{:.3g} ms; its own clock, about {:.3g} Hz, does not keep step with "
                           "them, so that they are right to one row",
                           sensor.name, 1e3 * row, 1.0 / own),
               "no harm; the sensor's own times would be better, where the logger knows them"};
}

}  // namespace

std::vector<Issue> check_order_and_finiteness(const NamedSeries& sensor) {
  const VectorSeries& s = *sensor.series;
  const auto fatal = [&](const char* kind, double t, std::string problem, std::string remedy) {
    return std::vector<Issue>{
        {kind, sensor.name, -1, Severity::kFatal, t, t, std::move(problem), std::move(remedy)}};
  };
  std::size_t bad = 0, first = 0;
  for (std::size_t k = s.size(); k-- > 0;) {
    if (std::isfinite(s.t[k]) && s.v[k].allFinite()) continue;
    ++bad;
    first = k;
  }
  if (bad > 0) {
    return fatal("not_finite", s.t[first],
                 fmt::format("{} has {} samples that are not finite numbers, the first at {:.3f} s",
                             sensor.name, bad, s.t[first]),
                 "leave out samples that the sensor did not deliver");
  }
  for (std::size_t k = 1; k < s.size(); ++k) {
    if (s.t[k] > s.t[k - 1]) continue;
    return fatal("time_order", s.t[k],
                 fmt::format("the time of {} {} at {:.6f} s (sample {})", sensor.name,
                             s.t[k] < s.t[k - 1] ? "goes backwards" : "is repeated", s.t[k], k),
                 "sort the samples by time, delete repeated ones, and cut the recording where its "
                 "clock was set back");
  }
  return {};
}

std::vector<Issue> check_intervals(const NamedSeries& sensor,
                                   const std::vector<SetAside>& set_aside,
                                   const VectorSeries& rows) {
  const std::vector<double> dt = intervals(*sensor.series);
  if (dt.size() < kFewestToJudge) return {};
  const double usual = 1.0 / sensor.series->rate_hz(), most_often = median(std::vector<double>(dt));
  std::vector<Issue> issues;
  std::vector<Gap> gaps;
  for (std::size_t k = 0; k < dt.size(); ++k) {
    if (dt[k] <= std::max(kGapIntervals * usual, kGapSeconds)) continue;
    const Gap gap{sensor.series->t[k], sensor.series->t[k + 1]};
    if (!left_by(set_aside, sensor.name, gap)) gaps.push_back(gap);
  }
  if (!gaps.empty()) issues.push_back(gap_issue(sensor, gaps, usual));
  const double large = spread_of(dt, usual, 0.0);
  if (!(large > kJitter)) return issues;
  if (auto in_rows = written_in_rows(sensor, dt, rows)) {
    issues.push_back(std::move(*in_rows));
  } else {
    const bool in_heaps = most_often < kInHeaps * usual;
    issues.push_back({"jitter", sensor.name, -1, Severity::kCaution, 0.0, 0.0,
                      in_heaps
                          ? fmt::format("the times of {} are those at which its samples arrived, "
                                        "several at once: most are {:.2g} ms apart, but there are "
                                        "{:.4g} a second",
                                        sensor.name, 1e3 * most_often, 1.0 / usual)
                          : fmt::format("the times of {} jitter: 5 % of its intervals differ from "
                                        "the usual {:.3g} ms by {:.0f} % and more",
                                        sensor.name, 1e3 * usual, 100.0 * large),
                      "log the time at which the sensor measured, not the one at which its data "
                      "arrived; a sensor with a steady clock may be given times k / rate"});
  }
  return issues;
}

std::vector<Issue> check_spans(const std::vector<NamedSeries>& sensors,
                               const std::vector<SetAside>& set_aside, double time_unit) {
  std::vector<Issue> issues;
  double longest = 0.0, first = 1e300, last = -1e300;
  for (const NamedSeries& s : sensors) {
    longest = std::max(longest, s.series->t.back() - s.series->t.front());
    first = std::min(first, s.series->t.front());
    last = std::max(last, s.series->t.back());
  }
  for (const NamedSeries& s : sensors) {
    double begin = s.series->t.front(), end = s.series->t.back();
    for (const SetAside& gone : set_aside) {
      if (gone.sensor != s.name) continue;
      begin = std::min(begin, gone.begin_s);
      end = std::max(end, gone.end_s);
    }
    if (end - begin >= kCommonSpan * (last - first)) continue;
    issues.push_back(
        {"span", s.name, -1, Severity::kCaution, begin, end,
         fmt::format("{} has samples from {:.2f} to {:.2f} s only, the recording lasts "
                     "from {:.2f} to {:.2f} s",
                     s.name, begin, end, first, last),
         "check that all sensors were logged by one clock, from begin to end"});
  }
  // No IMU delivers fewer samples than one a second: the times are in a smaller unit.
  const double dt = 1.0 / sensors.front().series->rate_hz();
  if (dt > 1.0) {
    const double step = dt / time_unit;  // in the file
    const char* unit = step < kInMicroseconds ? "ms" : step < kInNanoseconds ? "us" : "ns";
    const double factor = *unit_in_ours("t", unit) / time_unit;
    issues.push_back({"time_unit", sensors.front().name, -1, Severity::kFatal, 0.0, 0.0,
                      fmt::format("{} has a sample every {:.4g} s, if its time is in {}; it "
                                  "seems to be in {}",
                                  sensors.front().name, dt,
                                  time_unit == 1.0 ? "seconds" : "the unit that was given", unit),
                      factor < 1.0 ? fmt::format("give the unit of time: --unit t={} (in memory: "
                                                 "multiply the times by {:g})",
                                                 unit, factor)
                                   : "give the rate of the samples, --rate HZ, or their unit of "
                                     "time, --unit t=NUMBER (one of it in s)"});
  } else if (dt > 0.0 && dt < kFastest) {
    issues.push_back(
        {"time_unit", sensors.front().name, -1, Severity::kCaution, 0.0, 0.0,
         fmt::format("{} has {:.4g} samples a second, if its time is in seconds",
                     sensors.front().name, 1.0 / dt),
         "give the unit of time, such as --unit t=60 for minutes (in memory: multiply the "
         "times by that)"});
  }
  return issues;
}

}  // namespace magimu
