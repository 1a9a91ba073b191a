// SPDX-License-Identifier: BSD-3-Clause
// The two exact symmetries of the model: of the states that predict the same readings, the one that
// is reported. docs/theory.md says which.
#pragma once

#include <vector>

#include "calibration/motion/nodes.h"
#include "graph/values.h"

namespace magimu {

// Turns and inverts the values so that cos(dip) > 0 for every field, and det D > 0 for magnetometer
// 0. The residuals of all factors stay as they are.
void fix_symmetries(Values& values, int magnetometers, const std::vector<NodePlan>& plans);

}  // namespace magimu
