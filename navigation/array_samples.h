// SPDX-License-Identifier: BSD-3-Clause
// What a filter for an array takes: at every time of the IMU a sample of accelerometer and
// gyroscope, and where the magnetometers have measured since, the readings of all of them,
// interpolated to that time. Readings are those of a calibrated array (calibration/apply.h), in uT
// and in the axes of the IMU.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/recording.h"

namespace magimu {

struct ArraySamples {
  std::string name;
  std::vector<double> t;  // s
  std::vector<Vector3> acc, gyr;
  std::vector<Vector3> positions;  // of the magnetometers, m, in b
  MatrixXd mag;                    // 3 M x N, uT
  std::vector<bool> measured;      // whether the column of mag is a measurement
  // The truth at these times, in n; empty where it is not known.
  std::vector<Vector3> true_p;
  std::vector<Rot3> true_nRb;
  std::vector<bool> true_valid;
};

// InputError where there are not as many positions as magnetometers, or a sensor has no samples.
ArraySamples array_samples(const Recording& recording, const std::vector<Vector3>& positions);

}  // namespace magimu
