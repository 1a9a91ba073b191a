// SPDX-License-Identifier: BSD-3-Clause
// Where a magnet may stand that the sensor has passed: places on a grid about the path at which a
// dipole explains most of the magnetometer's residuals, the trajectory taken as it is.
#pragma once

#include "calibration/stage.h"

namespace magimu {

// The best few, m, in the frame of the recorded positions; best first.
std::vector<Vector3> likely_source_places(const Recording& recording, const Stage& stage);

}  // namespace magimu
