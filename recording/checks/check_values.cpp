// SPDX-License-Identifier: BSD-3-Clause
// Checks of readings by themselves: axes that never change, sensors that hang, clipping.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "recording/checks/quality_checks.h"
#include "recording/checks/rounding.h"
#include "recording/data/set_aside.h"
#include "recording/oddities/dead_zone.h"
#include "recording/oddities/sensor_habits.h"
#include "recording/oddities/usual_readings.h"

namespace magimu {
namespace {

constexpr double kStuckSeconds = 0.5;  // without any change
constexpr double kTurning = 0.2;       // rad/s: while the gyroscope says that it turns

bool constant_axis(const VectorSeries& s, int axis) {
  return std::ranges::all_of(s.v, [&](const Vector3& v) { return v[axis] == s.v.front()[axis]; });
}

// Mean rate of turn over a span; 0 without samples in it.
double mean_rate(const VectorSeries& gyr, double begin, double end) {
  const auto first = std::ranges::lower_bound(gyr.t, begin) - gyr.t.begin();
  const auto last = std::ranges::upper_bound(gyr.t, end) - gyr.t.begin();
  double sum = 0.0;
  for (auto k = first; k < last; ++k) sum += gyr.v[static_cast<std::size_t>(k)].norm();
  return last > first ? sum / static_cast<double>(last - first) : 0.0;
}

// Readings of 0, 0, 0 that are no measurement. (A gyroscope at rest may read 0, 0, 0.)
std::optional<Issue> zeros_issue(const NamedSeries& sensor) {
  const VectorSeries& s = *sensor.series;
  const double least = sensor.name == "gyr" ? kTurning : 0.0;
  std::size_t zeros = 0, first = 0, last_other = s.size();
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (!s.v[k].isZero(0.0)) {
      last_other = k;
    } else if (last_other == s.size() ? least == 0.0 : s.v[last_other].norm() > least) {
      if (zeros++ == 0) first = k;
    }
  }
  if (zeros == 0) return std::nullopt;
  return Issue{"zeros",
               sensor.name,
               -1,
               Severity::kCaution,
               s.t[first],
               s.t[first],
               fmt::format("{} reads exactly 0, 0, 0 in {} samples, first at {:.3f} s", sensor.name,
                           zeros, s.t[first]),
               "these are no measurements: leave the fields empty where the sensor has none"};
}

}  // namespace

bool all_constant(const VectorSeries& s) {
  return constant_axis(s, 0) && constant_axis(s, 1) && constant_axis(s, 2);
}

namespace {

// Did the axis jump to the value of samples [begin, end) and away from it, by more than it steps
// anywhere else? (A sensor that is clipped arrives and leaves in its usual steps.)
bool jumped_there(const VectorSeries& s, int axis, std::size_t begin, std::size_t end) {
  double in_and_out = INFINITY, elsewhere = 0.0;
  for (std::size_t k = 1; k < s.size(); ++k) {
    const double step = std::abs(s.v[k][axis] - s.v[k - 1][axis]);
    if (k == begin || k == end) {
      in_and_out = std::min(in_and_out, step);
    } else {
      elsewhere = std::max(elsewhere, step);
    }
  }
  return std::isfinite(in_and_out) && in_and_out > elsewhere;
}

// Does another axis change by a good part of its range during these samples?
bool others_move(const VectorSeries& s, int axis, std::size_t begin, std::size_t end) {
  constexpr double kGoodPart = 0.3;
  Vector3 low = s.v.front(), high = low, low_there = s.v[begin], high_there = low_there;
  for (std::size_t k = 0; k < s.size(); ++k) {
    low = low.cwiseMin(s.v[k]);
    high = high.cwiseMax(s.v[k]);
    if (k < begin || k >= end) continue;
    low_there = low_there.cwiseMin(s.v[k]);
    high_there = high_there.cwiseMax(s.v[k]);
  }
  const Vector3 whole = high - low, there = high_there - low_there;
  for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
    if (there[other] > kGoodPart * whole[other]) return true;
  }
  return false;
}

// Whether an axis cannot stay at its largest (sign 1) or smallest value: noise would move the
// reading, and the range does not end there.
bool cannot_stay(const VectorSeries& s, int axis, int sign) {
  SensorHabits habits;
  for (std::size_t k = 0; k < s.size(); ++k) habits.add(s.t[k], s.v[k]);
  return habits.lively(axis) && !habits.clipped(axis, sign);
}

// Does the axis hang until sample `last`? It does if the next reading is more than kSomeSteps steps
// away, or if there is none. A coarse converter's readings stand still, too, where the axis changes
// slowly, but then the next one is a step or two away.
bool goes_on_elsewhere(const VectorSeries& s, int axis, std::size_t last) {
  if (last + 1 >= s.size()) return true;
  double step = INFINITY;
  for (std::size_t k = 1; k < s.size(); ++k) {
    const double change = std::abs(s.v[k][axis] - s.v[k - 1][axis]);
    if (change > 0.0) step = std::min(step, change);
  }
  return std::abs(s.v[last + 1][axis] - s.v[last][axis]) > kSomeSteps * step;
}

// An axis that stands still while the others change: a run of one value that is longer than chance
// makes it. In n samples with a share r of repeats elsewhere, a run of m repeats is expected n r^m
// times. A run at an end of the range may be clipping or a rest, and does not count.
std::optional<Issue> stuck_axis(const NamedSeries& sensor, int axis) {
  constexpr double kExpected =
      1e-6;  // runs by chance that a recording may have, to count one as a fault
  const VectorSeries& s = *sensor.series;
  std::size_t longest = 0, at = 0, repeats = 0, lively = 0;
  double low = s.v.front()[axis], high = low;
  for (std::size_t k = 0, begin = 0, moving = 0; k < s.size(); ++k) {
    low = std::min(low, s.v[k][axis]);
    high = std::max(high, s.v[k][axis]);
    if (k + 1 < s.size() && s.v[k + 1][axis] == s.v[k][axis]) {
      moving += s.v[k + 1] != s.v[k] ? 1 : 0;
      ++repeats;
      continue;
    }
    if (k - begin > longest) {
      longest = k - begin;
      at = begin;
      lively = moving;
    }
    begin = k + 1;
    moving = 0;
  }
  const double value = s.v[at][axis], length = s.t[at + longest] - s.t[at];
  const double n = double(s.size());
  const double share = double(repeats - longest + 1) / (n - double(longest));
  if (length < kStuckSeconds || 2 * lively < longest) return std::nullopt;
  if (!goes_on_elsewhere(s, axis, at + longest)) return std::nullopt;
  const bool at_an_end = value == low || value == high;
  if (at_an_end && !jumped_there(s, axis, at, at + longest + 1) &&
      !(others_move(s, axis, at, at + longest + 1) &&
        cannot_stay(s, axis, value == high ? 1 : -1))) {
    return std::nullopt;
  }
  if (std::log(n) + double(longest) * std::log(share) > std::log(kExpected)) return std::nullopt;
  if (sensor.name == "gyr") {
    const std::optional<DeadZone> zone = dead_zone_of(s);
    if (zone && value == zone->reads[axis]) return std::nullopt;
  }
  return Issue{"stuck",
               sensor.name,
               axis,
               Severity::kCaution,
               s.t[at],
               s.t[at + longest],
               fmt::format("{}_{} does not change at all for {:.2f} s from {:.2f} s on, while the "
                           "other axes do",
                           sensor.name, axis_name(axis), length, s.t[at]),
               "the axis or its wire hung: cut that time out, or record again"};
}

// Two axes with the same numbers, or with inverted ones: a column that was written twice. Noise
// makes two axes differ in nearly all samples, so the same numbers in half of the changes are
// proof.
std::optional<Issue> copied_axis(const NamedSeries& sensor) {
  constexpr double kProof = 0.5;
  const VectorSeries& s = *sensor.series;
  for (int a = 0; a < 3; ++a) {
    for (int b = a + 1; b < 3; ++b) {
      std::size_t changes = 0, same = 0;
      for (std::size_t k = 1; k < s.size(); ++k) {
        if (s.v[k][a] == s.v[k - 1][a]) continue;
        ++changes;
        same += s.v[k][a] != 0.0 && std::abs(s.v[k][a]) == std::abs(s.v[k][b]) ? 1 : 0;
      }
      if (changes < kFewestToJudge || double(same) < kProof * double(changes)) continue;
      return Issue{
          "copied",
          sensor.name,
          b,
          Severity::kFatal,
          0.0,
          0.0,
          fmt::format("{0}_{1} and {0}_{2} hold the same numbers in {3:.0f} % of the samples",
                      sensor.name, axis_name(a), axis_name(b),
                      100.0 * double(same) / double(changes)),
          "check the logger: one of the two axes was written twice, and the other is not "
          "in the file"};
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<Issue> check_stuck(const NamedSeries& sensor, const VectorSeries& gyr, bool dead_band) {
  const VectorSeries& s = *sensor.series;
  std::vector<Issue> issues;
  if (s.size() < kFewestToJudge) return issues;
  if (all_constant(s)) {
    const Vector3& v = s.v.front();
    return {{"constant", sensor.name, -1, Severity::kFatal, 0.0, 0.0,
             fmt::format("{} reads ({:.6g}, {:.6g}, {:.6g}) {} in all {} samples", sensor.name,
                         v[0], v[1], v[2], sensor.unit(), s.size()),
             "check the logger and the sensor: nothing is measured"}};
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!constant_axis(s, axis)) continue;
    issues.push_back({"constant", sensor.name, axis, Severity::kFatal, 0.0, 0.0,
                      fmt::format("{}_{} is {:.6g} {} in all {} samples", sensor.name,
                                  axis_name(axis), s.v.front()[axis], sensor.unit(), s.size()),
                      "check the logger and the sensor: this axis is not measured"});
  }
  if (!issues.empty()) return issues;
  if (auto copied = copied_axis(sensor)) return {*std::move(copied)};
  double longest = 0.0, at = 0.0, total = 0.0;
  for (std::size_t k = 0, begin = 0; k < s.size(); ++k) {
    if (k + 1 < s.size() && s.v[k + 1] == s.v[begin]) continue;
    const double length = s.t[k] - s.t[begin];
    const bool own = sensor.series == &gyr;  // a gyroscope that hangs cannot testify
    if (length > kStuckSeconds &&
        (own ? s.v[k].norm() : mean_rate(gyr, s.t[begin], s.t[k])) > kTurning &&
        (goes_on_elsewhere(s, 0, k) || goes_on_elsewhere(s, 1, k) || goes_on_elsewhere(s, 2, k))) {
      total += length;
      if (length > longest) at = s.t[begin];
      longest = std::max(longest, length);
    }
    begin = k + 1;
  }
  if (longest > 0.0) {
    issues.push_back({"stuck", sensor.name, -1, Severity::kCaution, at, at + longest,
                      fmt::format("{} does not change at all for {:.2f} s from {:.2f} s on "
                                  "({:.1f} s in all), while the sensor turns",
                                  sensor.name, longest, at, total),
                      "the sensor or its bus hung: leave such samples out, or record again"});
  }
  // An axis in coarse steps stands still, too, while it changes slowly.
  const bool coarse = !sensor.is_mag() && coarse_steps(s);
  const bool slow = coarse || (dead_band && sensor.series == &gyr);
  for (int axis = 0; axis < 3 && issues.empty() && !slow; ++axis) {
    if (auto stuck = stuck_axis(sensor, axis)) issues.push_back(std::move(*stuck));
  }
  if (auto zeros = zeros_issue(sensor)) issues.push_back(std::move(*zeros));
  return issues;
}

std::vector<Issue> check_saturation(const NamedSeries& sensor) {
  const VectorSeries& s = *sensor.series;
  SensorHabits habits;
  for (std::size_t k = 0; k < s.size(); ++k) habits.add(s.t[k], s.v[k]);
  std::vector<Issue> issues;
  for (int axis = 0; axis < 3; ++axis) {
    if (constant_axis(s, axis)) continue;
    for (const int sign : {1, -1}) {
      if (!habits.clipped(axis, sign)) continue;
      const ExtremeValues::Value& e = habits.end(axis, sign).top();
      const std::optional<Issue> stuck = stuck_axis(sensor, axis);
      if (stuck && stuck->begin_s <= e.first_s && e.last_s <= stuck->end_s) continue;
      issues.push_back(
          {"saturation", sensor.name, axis, Severity::kCaution, e.first_s, e.last_s,
           fmt::format("{}_{} reads {:.5g} {}, its {}, in {} samples between {:.2f} and {:.2f} s, "
                       "up to {} in a row: it is clipped",
                       sensor.name, axis_name(axis), habits.limit(axis, sign), sensor.unit(),
                       sign > 0 ? "largest" : "smallest", e.count, e.first_s, e.last_s,
                       e.longest_run),
           sensor.is_mag() ? "choose a larger range, or go away from the magnet"
                           : "choose a larger range, or move more gently"});
    }
  }
  return issues;
}

namespace {

const VectorSeries* series_named(const Recording& recording, const std::string& sensor) {
  if (sensor == "acc") return &recording.acc;
  if (sensor == "gyr") return &recording.gyr;
  const auto at = std::ranges::find(recording.mag_names, sensor);
  const auto m = std::size_t(at - recording.mag_names.begin());
  return m < recording.mag.size() ? &recording.mag[m] : nullptr;
}

// Whether samples that were set aside leave a gap: hardly one between them stays. Those before and
// after it are as good as ever.
bool leaves_gap(const Recording& recording, const SetAside& s) {
  const VectorSeries* const series = series_named(recording, s.sensor);
  if (series == nullptr) return false;
  const auto first = std::ranges::lower_bound(series->t, s.begin_s);
  const auto last = std::ranges::upper_bound(series->t, s.end_s);
  return double(last - first) < kSetAsideFew * double(s.count);
}

}  // namespace

std::vector<Issue> check_set_aside(const Recording& recording) {
  std::vector<Issue> issues;
  std::map<std::string, double> lost, scattered;
  for (const SetAside& s : recording.set_aside) {
    lost[s.sensor] += lost_share(s);
    if (!leaves_gap(recording, s)) scattered[s.sensor] += lost_share(s);
  }
  for (const SetAside& s : recording.set_aside) {
    const double share = lost[s.sensor];
    Issue issue{"set_aside", s.sensor, -1,          Severity::kNote,
                s.begin_s,   s.end_s,  sentence(s), remedy(s)};
    if (lost_share(s) > 0.0 && share > kSetAsideFew) issue.severity = Severity::kCaution;
    issues.push_back(issue);
    if (scattered[s.sensor] <= kSetAsideMost) continue;
    issue.severity = Severity::kFatal;
    issue.problem = fmt::format("{:.0f} % of the samples of {} are no measurements ({})",
                                100.0 * share, s.sensor, sentence(s));
    issues.push_back(issue);
    lost[s.sensor] = scattered[s.sensor] = 0.0;  // once
  }
  return issues;
}

}  // namespace magimu
