// SPDX-License-Identifier: BSD-3-Clause
// Extrinsic calibration: the rotation between the magnetometer's and the IMU's frame, together
// with the gyroscope bias, from how the field direction turns (Wu et al. 2016; see
// factors/field_rotation_factor.h). Starts from the 24 ways to mount a sensor along the axes, so no
// prior knowledge of the mounting is needed.
#pragma once

#include <vector>

#include "calibration/start/intrinsic.h"
#include "recording/data/recording.h"

namespace magimu {

struct Alignment {
  Rot3 mRb;                            // IMU frame to the magnetometer's; D = D_I mRb
  Vector3 gyr_bias = Vector3::Zero();  // rad/s
  double residual_rms_rad = 0.0;       // how well the field's turning agrees with the gyroscope
};

struct AlignmentOptions {
  Vector3 gyr_bias = Vector3::Zero();  // where to start, rad/s
  bool estimate_gyr_bias = true;
  int max_pairs = 1500;
};

// magnetometer: its index in every recording; intrinsic: its ellipsoid.
Alignment align_magnetometer(const std::vector<const Recording*>& recordings,
                             std::size_t magnetometer, const IntrinsicCalibration& intrinsic,
                             const AlignmentOptions& options = {});

}  // namespace magimu
