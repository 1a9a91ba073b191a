// SPDX-License-Identifier: BSD-3-Clause
// A recording as filters go through it: steps in the order of time, each with the samples that were
// taken then and the rotation rate held until the next step. A step begins wherever a sample of any
// sensor is, so that a magnetometer need not be in step with the IMU.
#pragma once

#include <vector>

#include "recording/data/recording.h"

namespace magimu {

struct FilterStep {
  struct Mag {
    int sensor = 0;                   // index of the magnetometer
    Vector3 value = Vector3::Zero();  // uT
  };
  double t = 0.0;  // s
  bool has_acc = false;
  Vector3 acc = Vector3::Zero();  // m/s^2
  std::vector<Mag> mag;
  Vector3 rate = Vector3::Zero();  // measured, rad/s, from t to t + dt
  double dt = 0.0;                 // s; 0 at the last step
};

// Samples outside the gyroscope's span are left out: no attitude leads there.
std::vector<FilterStep> filter_steps(const Recording& recording);

}  // namespace magimu
