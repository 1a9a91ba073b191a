// SPDX-License-Identifier: BSD-3-Clause
// The paper's model for studies: the sensor only turns, the magnetometers do not lag, the gyroscope
// has no scale errors, and the noise is given.
#pragma once

#include "calibration/result/calibration_options.h"

namespace magimu {

// noise: densities (calibration_options.h). gravity: m/s^2. node_every: magnetometer samples a
// node; 0: as calibrate() chooses.
inline CalibrationOptions rotation_model(const NoiseDensities& noise, double gravity,
                                         int node_every = 0) {
  CalibrationOptions options;
  options.noise = noise;
  options.gravity = gravity;
  options.motion = MotionModel::kRotation;
  options.mag_time_offset = false;
  options.gyr_matrix = false;
  options.node_every = node_every;
  return options;
}

}  // namespace magimu
