// SPDX-License-Identifier: BSD-3-Clause
// What the readings before and after say that some readings in a row should be. Internal to the
// gate (sensor_gate.h).
#pragma once

#include "recording/oddities/usual_readings.h"

namespace magimu {

struct Neighbours {
  Vector3 middle, spread;  // as in LocalCourse; spread is infinite where there are too few
  Vector3 bend;        // the largest departure of one of them from the mean of the two beside it
  bool before, after;  // at least two readings on that side

  bool both() const { return before && after; }
};

// Around the first `run` readings that wait. The hand moves on meanwhile, so the middle is that of
// a local course; readings beyond a gap are left out. With neighbours on one side alone there is no
// course: the middle is their median, and the spread contains the motion.
Neighbours neighbours_of(const ReadingsAround& readings, std::size_t run);

}  // namespace magimu
