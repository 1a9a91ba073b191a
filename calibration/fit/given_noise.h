// SPDX-License-Identifier: BSD-3-Clause
// Noise densities that were given, against what the recordings show: a wrong unit, or the noise of
// a sample in place of a density, weighs the sensors wrongly, and far enough off no fit can be
// made.
#pragma once

#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"

namespace magimu {

// Adds a check and lowers the verdict where a density is off by ten times or more. Where no fit
// could be made the samples themselves are asked, and what they say is the first reason.
void judge_given_noise(Calibration& c, const std::vector<const Recording*>& recordings,
                       const CalibrationOptions& options);

}  // namespace magimu
