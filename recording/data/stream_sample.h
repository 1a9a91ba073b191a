// SPDX-License-Identifier: BSD-3-Clause
// One moment of a stream: what the sensors of a board read at one time. Recordings hold series
// (recording.h), streams hand over samples one by one, and a journal of them is a stream's memory.
#pragma once

#include <optional>
#include <vector>

#include "graph/rot3.h"

namespace magimu {

// What the sensors read at one time; a sensor without a sample at that time has none.
struct StreamSample {
  double t = 0.0;                           // s, greater than that of the sample before
  std::optional<Vector3> acc, gyr;          // m/s^2, rad/s
  std::vector<std::optional<Vector3>> mag;  // uT, one entry a magnetometer
};

}  // namespace magimu
