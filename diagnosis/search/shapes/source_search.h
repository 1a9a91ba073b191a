// SPDX-License-Identifier: BSD-3-Clause
// Where a magnet may stand that the sensor has passed: places about the path at which a dipole
// explains most of what the magnetometer leaves.
#pragma once

#include "calibration/fit/stage.h"

namespace magimu {

struct LikelySource {
  Vector3 place, moment;  // m, in the frame of the recorded positions; A m^2
};

// The best few, best first: by the scan, trajectory and calibration eliminated. (A source bends the
// trajectory and the calibration of a fit without it, so that what is left there points elsewhere.)
std::vector<LikelySource> likely_sources(const std::vector<const Recording*>& recordings,
                                         const Stage& stage);

// The same with the trajectory taken as it is, which is coarser. For a stage that has a source in
// its model already: that source is looked for anew.
std::vector<LikelySource> sources_by_residual(const Recording& recording, const Stage& stage);

}  // namespace magimu
