// SPDX-License-Identifier: BSD-3-Clause
// Windows of a recording's nodes, which are condensed one by one (condensed_windows.h): for scans,
// held-out likelihoods and robust covariances. A window is longer than residuals stay correlated
// and than the trajectory carries an error on.
#pragma once

#include "calibration/model/model.h"
#include "calibration/motion/nodes.h"
#include "solvers/condensed/condensed_windows.h"

namespace magimu {

// The node of a variable of a calibration graph; -1 for a parameter.
int node_of(Key key);

// Seconds in which a window by itself shows what an effect on this sensor does. Where the motion is
// estimated, too, the accelerometer says little in few seconds.
double window_s(Sensor channel, MotionModel motion);

// The window of each node, numbered through all recordings. A recording's windows are equally long,
// and about `seconds`.
std::vector<int> windows_of(const std::vector<NodePlan>& plans, double seconds = 5.0);

}  // namespace magimu
