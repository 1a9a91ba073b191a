// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "graph/parallel.h"
#include "recording/checks/quality_checks.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

std::vector<NamedSeries> sensors_of(const Recording& recording) {
  std::vector<NamedSeries> out{{"acc", &recording.acc}, {"gyr", &recording.gyr}};
  for (std::size_t i = 0; i < recording.mag.size(); ++i) {
    const bool named = i < recording.mag_names.size();
    out.push_back(
        {named ? recording.mag_names[i] : "mag" + std::to_string(i + 1), &recording.mag[i]});
  }
  std::erase_if(out, [](const NamedSeries& s) { return s.series->empty(); });
  return out;
}

void append(std::vector<Issue>& all, std::vector<Issue>&& more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

// Where all sensors stop at once the logger did, or its clock jumped: what follows is a part of its
// own, and nothing has to be mended.
void tell_of_common_gap(std::vector<Issue>& issues, std::size_t sensors) {
  std::vector<Issue*> gaps;
  for (Issue& issue : issues) {
    if (issue.kind == "gap") gaps.push_back(&issue);
  }
  if (gaps.size() < sensors) return;
  double begin = -INFINITY, end = INFINITY, longest = 0.0;
  for (const Issue* gap : gaps) {
    begin = std::max(begin, gap->begin_s);
    end = std::min(end, gap->end_s);
    longest = std::max(longest, gap->end_s - gap->begin_s);
  }
  if (end - begin < 0.5 * longest) return;
  for (Issue* gap : gaps) {
    gap->severity = Severity::kNote;
    gap->remedy =
        "all sensors stop there: the logger paused, or its clock jumped; after a gap that the "
        "motion does not let bridge a new part of the recording begins, with an attitude of its "
        "own";
  }
}

bool has_dead_band(const Recording& recording) {
  return std::ranges::count(recording.set_aside, "dead_zone", &SetAside::kind) > 0;
}

// Seconds that the file's numbers were taken for.
double file_time_unit(const Recording& recording) {
  const auto unit = recording.file_units.find("t");
  return unit == recording.file_units.end() ? 1.0 : unit->second;
}

}  // namespace

std::string to_string(Severity severity) {
  return severity == Severity::kFatal     ? "fatal"
         : severity == Severity::kCaution ? "caution"
                                          : "note";
}

std::string axis_name(int axis) { return {"xyz"[axis]}; }

bool damages(const Issue& issue) {
  // Interpolated and repeated samples are handled, and told where it matters; so is what the reader
  // had to change.
  return issue.severity == Severity::kFatal ||
         (issue.severity == Severity::kCaution && issue.kind != "interpolation" &&
          issue.kind != "repeats" && issue.kind != "left_out" && issue.kind != "jitter" &&
          issue.kind != "vibration" && issue.kind != "reader");
}

// Nodes may take the means of two devices' rows, which fit each other well.
KnownFault known_fault(const std::string& source, const Issue& issue) {
  return {source + ": " + issue.text(), issue.kind == "mixed"};
}

std::vector<Issue> check_recording(const Recording& recording) {
  const std::vector<NamedSeries> sensors = sensors_of(recording);
  std::vector<Issue> issues;
  for (const NamedSeries& sensor : sensors) append(issues, check_order_and_finiteness(sensor));
  if (issues.empty()) {
    append(issues, check_set_aside(recording));
    // Where nothing at all changes (a simulated rest without noise) no single sensor is to blame.
    const bool still = std::ranges::all_of(
        sensors, [](const NamedSeries& sensor) { return all_constant(*sensor.series); });
    for (std::size_t i = 0; i < sensors.size() && !still; ++i) {
      append(issues, check_stuck(sensors[i], recording.gyr, has_dead_band(recording)));
    }
    append(issues, check_spans(sensors, recording.set_aside, file_time_unit(recording)));
    // Rates in another unit of time would look like a gyroscope in another unit, and motion like
    // vibration.
    const auto in_seconds = [&issues] {
      return std::ranges::none_of(issues,
                                  [](const Issue& issue) { return issue.kind == "time_unit"; });
    };
    if (in_seconds()) append(issues, check_units(recording));
    // A gyroscope whose unit is wrong seems to turn while it rests, so that readings that do not
    // change at rest would be called stuck.
    const bool rates = std::ranges::none_of(issues, [](const Issue& issue) {
      return issue.sensor == "gyr" && issue.kind == "unit" && issue.severity == Severity::kFatal;
    });
    if (!rates) {
      std::erase_if(issues, [](const Issue& i) { return i.kind == "stuck" && i.axis < 0; });
    }
    const bool seconds = in_seconds();
    std::vector<std::vector<Issue>> of_sensor(sensors.size());
    parallel::for_each(sensors.size(), [&](std::size_t i) {
      const NamedSeries& sensor = sensors[i];
      std::vector<Issue>& own = of_sensor[i];
      own = check_intervals(sensor, recording.set_aside, recording.gyr);
      if (still || all_constant(*sensor.series)) return;
      append(own, check_saturation(sensor));
      if (seconds) append(own, check_vibration(sensor));
      std::vector<Issue> of_clock = check_other_motion(sensor);
      if (of_clock.empty()) of_clock = check_clock(sensor);
      if (of_clock.empty()) of_clock = check_mixed(sensor);
      append(own, std::move(of_clock));
    });
    for (std::vector<Issue>& own : of_sensor) append(issues, std::move(own));
    tell_of_common_gap(issues, sensors.size());
  }
  std::ranges::stable_sort(issues,
                           [](const Issue& a, const Issue& b) { return a.severity > b.severity; });
  return issues;
}

void refuse_fatal(const Recording& recording, const std::vector<Issue>& issues) {
  const std::string_view one_unit = "give the file's unit: ";
  std::vector<std::string> problems, units, others;
  for (const Issue& issue : issues) {
    if (issue.severity != Severity::kFatal) continue;
    problems.push_back(issue.problem);
    const bool unit = issue.remedy.starts_with(one_unit);
    (unit ? units : others).push_back(issue.remedy.substr(unit ? one_unit.size() : 0));
  }
  if (problems.empty()) return;
  if (!units.empty()) {
    const std::string_view give = units.size() == 1 ? one_unit : "give the file's units: ";
    others.insert(others.begin(), fmt::format("{}{}", give, fmt::join(units, " ")));
  }
  throw InputError(recording.name, 0, 0, fmt::format("{}", fmt::join(problems, "; ")),
                   fmt::format("{}", fmt::join(others, "; ")));
}

}  // namespace magimu
