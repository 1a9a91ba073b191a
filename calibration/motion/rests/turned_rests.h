// SPDX-License-Identifier: BSD-3-Clause
// A slow turn looks like a rest where the gyroscope alone is asked for half a second: a ship that
// rolls by 10 deg in 8 s. Over a second and more the other sensors tell. Gravity's direction in the
// accelerometer (and the field in the magnetometer, about the vertical) moves as the integrated
// gyroscope says, or faster than an accelerometer drifts. What moved is no rest.
#pragma once

#include <vector>

#include "calibration/motion/rests/rests.h"

namespace magimu {

// The parts of these spans in which no turn can be proved. A turn counts if it makes more than half
// of what a sensor's means of a quarter of a second move by, and not by chance; a smaller one is
// less than the noise of these means and so less than that of samples.
std::vector<TimeSpan> without_turns(const Recording& recording, const std::vector<TimeSpan>& rests);

}  // namespace magimu
