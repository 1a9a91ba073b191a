// SPDX-License-Identifier: BSD-3-Clause
// How far a calibration is from the oracle's device.
#pragma once

#include "calibration/result/calibration.h"
#include "study/error_statistics.h"
#include "tests/oracle/sensors.h"

namespace magimu::test {

inline constexpr double kOutside = 43.820;  // chi-square of 19 degrees of freedom, 99.9 %

// Of the 19 parameters, in the calibration's order.
inline VectorXd error_of(const Calibration& c, const oracle::Device& device) {
  SensorParameters truth;
  truth.acc_bias = device.acc_bias;
  truth.gyr_bias = device.gyr_bias;
  truth.dip_rad = device.dip_rad;
  truth.mag = {{device.distortion, device.mag_bias}};
  return in_calibration_order(c).head(19) - in_calibration_order(truth, {device.dip_rad});
}

}  // namespace magimu::test
