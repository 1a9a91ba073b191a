// SPDX-License-Identifier: BSD-3-Clause
// Whether a sensor hangs: it repeats a reading although what it measures changed. A run of equal
// readings is first of all longer than chance makes it. Then the sensor itself shows it, by a jump
// at the end of the run, or other sensors do. Internal to the gate (sensor_gate.h).
#pragma once

#include <functional>

#include "recording/oddities/usual_readings.h"

namespace magimu {

// What other sensors say; as in SensorGate::Options, empty where they are not asked.
struct OtherSensors {
  const std::function<bool(double begin_s, double end_s)>& turned;
  const std::function<bool(double begin_s, double end_s)>& others_change;
};

// Whether the first reading that waits is one at which the sensor hung.
bool hangs(const ReadingsAround& readings, const UsualReadings& usual, const OtherSensors& others);

}  // namespace magimu
