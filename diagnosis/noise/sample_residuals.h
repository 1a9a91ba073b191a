// SPDX-License-Identifier: BSD-3-Clause
// What a fitted model leaves of single samples, for the tests of the noise (noise_tests.h).
#pragma once

#include "calibration/fit/stage.h"
#include "diagnosis/noise/noise_tests.h"

namespace magimu {

// acc, gyr, mag of one recording. The trajectory follows the gyroscope, and when the sensor is
// moved the accelerometer, too: of these only what is faster than the trajectory is left.
std::vector<SampleResiduals> sample_residuals(const Recording& recording, const Stage& stage,
                                              int index, const NoiseDensities& rest,
                                              bool noise_given);

}  // namespace magimu
