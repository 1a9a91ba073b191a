// SPDX-License-Identifier: BSD-3-Clause
// Readings that wrapped: the converter, or a 16-bit variable, went from one end of its range to the
// other and on in the same direction, until it turned back. Internal to the gate (sensor_gate.h).
#pragma once

#include <array>
#include <map>
#include <optional>

#include "recording/oddities/usual_readings.h"

namespace magimu {

class WrappedReadings {
 public:
  // By how many whole ranges the first reading of each axis is off, as an earlier pass found.
  void begin_with(const std::array<int, 3>& turns) { turns_over_ = turns; }
  // The axis on which the first reading that waits has wrapped. `waits`: for how long a stream may
  // wait for a reading to come back, s; none for a file, whose readings afterwards are all there.
  std::optional<int> wrapped_axis(const RepeatedReadings& waiting, const UsualReadings& usual,
                                  std::optional<double> waits_s);
  // A reading that was kept.
  void follow(const RepeatedReading& unit, const UsualReadings& usual);
  // By how many whole ranges most readings of an axis are off, if the first ones were not.
  std::array<int, 3> usual_turns() const;

 private:
  void turn_over(const RepeatedReadings& waiting, const UsualReadings& usual, bool whole_file);

  std::array<int, 3> turns_over_ = {0, 0, 0};  // by how many whole ranges the axes are off now
  double right_s_ = 0.0;                       // time of the last reading that had not wrapped
  std::array<std::map<int, std::size_t>, 3> turns_seen_;
  std::deque<Vector3> path_;   // the last readings, as if they had not wrapped
  std::deque<double> path_s_;  // their times
  Vector3 last_ = Vector3::Zero();
};

}  // namespace magimu
