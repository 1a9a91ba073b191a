// SPDX-License-Identifier: BSD-3-Clause
// Where a magnet may stand that the sensor has passed: places on a grid about the path at which a
// dipole explains most of the magnetometer's residuals, the trajectory taken as it is.
#pragma once

#include "calibration/stage.h"

namespace magimu {

struct LikelySource {
  Vector3 place, moment;  // m, in the frame of the recorded positions; A m^2
};

// The best few, best first. A source that is in the stage's model already is looked for anew.
std::vector<LikelySource> likely_sources(const Recording& recording, const Stage& stage);

}  // namespace magimu
