// SPDX-License-Identifier: BSD-3-Clause
// The single checks behind quality.h, and what they share. Internal to recording/.
#pragma once

#include <string>
#include <vector>

#include "graph/sensor.h"
#include "recording/checks/quality.h"

namespace magimu {

// Samples, intervals or changes: with fewer a check says nothing.
inline constexpr std::size_t kFewestToJudge = 20;

struct NamedSeries {
  std::string name;  // "acc", "gyr", "mag", "mag1", ...
  const VectorSeries* series;
  bool is_mag() const { return name.starts_with("mag"); }
  const char* unit() const { return unit_of(sensor_named(name)); }
};

// Times that are not finite or do not increase, values that are not finite: nothing else can be
// judged then.
std::vector<Issue> check_order_and_finiteness(const NamedSeries& sensor);
// Gaps and jitter. `set_aside`: of this recording; their gaps are not reported again. `rows`: the
// series in whose rows a slower sensor's readings may have been written.
std::vector<Issue> check_intervals(const NamedSeries& sensor,
                                   const std::vector<SetAside>& set_aside,
                                   const VectorSeries& rows);
// Sensors that do not cover the same time, samples that were set aside counted; times that are no
// seconds. `time_unit`: that of the file, s, as the reader took it.
std::vector<Issue> check_spans(const std::vector<NamedSeries>& sensors,
                               const std::vector<SetAside>& set_aside, double time_unit);
// Samples that were set aside before (gate.h).
std::vector<Issue> check_set_aside(const Recording& recording);
// Whether no axis ever changes.
bool all_constant(const VectorSeries& series);
// Axes that never change, stretches in which nothing changes, readings of zero.
// dead_band: the gate has found that the gyroscope has one; its axes stand still where they turn
// slowly.
std::vector<Issue> check_stuck(const NamedSeries& sensor, const VectorSeries& gyr, bool dead_band);
std::vector<Issue> check_saturation(const NamedSeries& sensor);
// An accelerometer on something that vibrates all the time, such as a motor.
std::vector<Issue> check_vibration(const NamedSeries& sensor);
// Samples that repeat the one before, or lie on a line between neighbours: a slower clock.
std::vector<Issue> check_clock(const NamedSeries& sensor);
// Samples that come from two devices in turn. Interpolated ones do not count.
std::vector<Issue> check_mixed(const NamedSeries& sensor);
// The same where the other device is turned otherwise.
std::vector<Issue> check_other_motion(const NamedSeries& sensor);

}  // namespace magimu
