// SPDX-License-Identifier: BSD-3-Clause
// Does the calibration make orientation better than the readings are as they come? One recording
// can answer that for what changes with the attitude: samples of the magnetometer that the fit has
// not seen are predicted with the calibration and with the readings as they are, each with its own
// attitudes, dip and biases of the inertial sensors. What is constant (a tilt of the whole, by the
// accelerometer's bias, or a turn of D) it cannot compare: there the sigmas speak.
#pragma once

#include "calibration/fit/held_out.h"
#include "calibration/result/calibration.h"

namespace magimu {

// The same model fitted with magnetometers that need no calibration but for how their axes are
// mounted: no bias, and D a scale times the nearest of 24 mountings. Throws NumericalError.
Stage with_readings_as_they_come(const std::vector<const Recording*>& recordings,
                                 const Stage& stage);

// How far the readings as they come are off, rad, by a calibration: at the worst attitude, about.
double correction_rad(const Matrix3& D, const Vector3& bias);
// Beyond this no left-out sample need be asked: few recordings are known so badly.
inline constexpr double kObviousCorrection = 0.3;  // rad
Check no_gain_to_ask_for(double correction_rad);

// The check "gain": errors of direction, degrees RMS an axis. value: how many times smaller the
// calibration's is. Bad where the readings as they come predict better.
Check check_gain(const BlockErrors& as_they_come, const BlockErrors& calibrated,
                 double strength_uT);

}  // namespace magimu
