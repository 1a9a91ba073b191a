// SPDX-License-Identifier: BSD-3-Clause
// What follows for a calibration from whether the sensors' axes agree (mounting.h): a check with a
// sentence, and the verdict `no` where no model of ours carries it.
#pragma once

#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"
#include "calibration/trust/mounting.h"

namespace magimu {

// The check "axes". distortion: of the first magnetometer; gyr: what multiplies the rates. Their
// rotations are told where they are more than a package's misalignment. dip_rad: as calibrated.
// dip_sign: that of the true dip where the user knows it (1 on the northern hemisphere, -1 on the
// southern, 0: unknown), which tells a magnetometer that is turned from one that is inverted.
Check check_axes(const Mounting& mounting, const Matrix3& distortion, double dip_rad, int dip_sign,
                 const Matrix3& gyr = Matrix3::Identity());

// Of the first recording whose motion tells.
Mounting check_mounting(const std::vector<const Recording*>& recordings);

// Adds that check to c, and lowers the verdict: to `no` where accelerometer and gyroscope disagree,
// which no model of ours carries; to `limited` where the magnetometer is turned, which D holds, or
// inverted.
void judge_axes(Calibration& c, const Mounting& mounting, const CalibrationOptions& options);

}  // namespace magimu
