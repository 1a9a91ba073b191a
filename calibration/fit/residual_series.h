// SPDX-License-Identifier: BSD-3-Clause
// What a fit leaves of each sensor, over time: for pictures and for tests of its noise.
#pragma once

#include <vector>

#include "calibration/fit/optimum.h"
#include "calibration/result/calibration.h"

namespace magimu {

// At the stage's optimum: accelerometer, gyroscope, then the magnetometers with these names, first
// ones first; all recordings one after the other. Of a hand-held sensor's accelerometer: the
// velocity gained from node to node.
std::vector<ResidualSeries> residual_series(const Optimum& at,
                                            const std::vector<std::string>& mag_names);

}  // namespace magimu
