// SPDX-License-Identifier: BSD-3-Clause
// May this calibration be believed? The verdict, with reasons in words: did the fit converge, is
// everything determined, is the motion one that the model can carry, do the residuals look like
// noise.
#pragma once

#include "calibration/calibrate.h"

namespace magimu {

void judge(Calibration& c, const std::vector<const Recording*>& recordings);

}  // namespace magimu
