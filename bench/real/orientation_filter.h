// SPDX-License-Identifier: BSD-3-Clause
// One fixed, ordinary orientation filter, for judging calibrations by what they do in somebody
// else's hands: a complementary filter. The gyroscope turns the attitude, the accelerometer pulls
// it upright and the horizontal part of the magnetometer pulls it north, each with a fixed time
// constant; run forward and backward, the two halfway between. It estimates nothing about the
// sensors, so its errors are those of the calibration (and of the hand, whose accelerations it
// takes for gravity).
//
//   const TrajectoryEstimate raw = track(recording, {});
//   const TrajectoryEstimate cal = track(recording, corrections(calibration));
#pragma once

#include "calibration/result/calibration.h"
#include "factors/preintegrated_imu.h"
#include "recording/data/recording.h"

namespace magimu {

// What a calibration tells about the sensors. As it is, they are taken at their word: no biases, no
// distortion. (The filter needs neither the strength of the field nor its dip.)
struct Corrections {
  SensorParameters parameters;
  double mag_lag_s = 0.0;
  GyroMatrix gyr_matrix = GyroMatrix::Zero();  // gyr = (I + S) omega + o_w
};
Corrections corrections(const Calibration& calibration);

// Time constants as in VQF (Laidig and Seel 2023), whose defaults were chosen on many recordings
// of many sensors: not tuned to those we judge.
struct FilterOptions {
  double acc_time_s = 3.0;
  double mag_time_s = 9.0;
};

// The recording's attitudes at its accelerometer's samples, by magnetometer 0.
TrajectoryEstimate track(const Recording& recording, const Corrections& corrections,
                         const FilterOptions& options = {});

}  // namespace magimu
