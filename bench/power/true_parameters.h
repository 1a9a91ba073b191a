// SPDX-License-Identifier: BSD-3-Clause
// The oracle's truth as a calibration has it.
#pragma once

#include "factors/sensor_model.h"
#include "tests/oracle/device.h"

namespace magimu {

inline SensorParameters true_parameters(const oracle::Device& device) {
  SensorParameters p;
  p.acc_bias = device.acc_bias;
  p.gyr_bias = device.gyr_bias;
  p.dip_rad = device.dip_rad;
  p.mag = {{device.distortion, device.mag_bias}};
  return p;
}

}  // namespace magimu
