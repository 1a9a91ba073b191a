// SPDX-License-Identifier: BSD-3-Clause
// What a filter for an array takes: at every time of the accelerometer the force and the rate of
// the step to the next, and where the magnetometers have measured, the readings of all of them,
// interpolated to that time. Readings are those of a calibrated array (calibration/use/apply.h), in
// uT and in the axes of the IMU.
//
// What a step's force and rate are decides how well the filter does. The accelerometer's samples
// are instants: over a step the force is the mean of its two ends, in the frame of its start. The
// gyroscope's are means over intervals (Recording): over a step the rate is that of all intervals
// in it. The published filters hold the sample at a step's start over the whole step instead, which
// delays a motion by half a sample: at 100 Hz and 2 m/s that was most of their position's error
// (bench/README.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

enum class StepReadings {
  kMean,  // the mean over the step, as explained above
  kHeld,  // the sample at the step's start, as published
};

struct ArraySamples {
  std::string name;
  std::vector<double> t;           // s
  std::vector<Vector3> acc, gyr;   // m/s^2, rad/s, from t[k] to t[k + 1]; of the last: as before it
  std::vector<Vector3> positions;  // of the magnetometers, m, in b
  MatrixXd mag;                    // 3 M x N, uT
  std::vector<bool> measured;      // whether the column of mag is a measurement
  // The truth at these times, in n; empty where it is not known.
  std::vector<Vector3> true_p;
  std::vector<Rot3> true_nRb;
  std::vector<bool> true_valid;
};

// InputError where there are not as many positions as magnetometers, or a sensor has no samples.
ArraySamples array_samples(const Recording& recording, const std::vector<Vector3>& positions,
                           StepReadings readings = StepReadings::kMean);

}  // namespace magimu
