// SPDX-License-Identifier: BSD-3-Clause
// One fixed, ordinary orientation filter, for judging calibrations by what they do in somebody
// else's hands: a complementary filter. The gyroscope turns the attitude, the accelerometer pulls
// it upright and the horizontal part of the magnetometer pulls it north, each with a fixed time
// constant; run forward and backward, the two halfway between. It estimates nothing about the
// sensors, so its errors are those of the calibration (and of the hand, whose accelerations it
// takes for gravity).
//
//   const TrajectoryEstimate raw = track(recording, uncalibrated());
//   const TrajectoryEstimate cal = track(recording, c.parameters, magnetometer_lag_s(c));
#pragma once

#include "calibration/calibration.h"
#include "recording/recording.h"

namespace magimu {

// Time constants as in VQF (Laidig and Seel 2023), whose defaults were chosen on many recordings
// of many sensors: not tuned to those we judge.
struct FilterOptions {
  double acc_time_s = 3.0;
  double mag_time_s = 9.0;
};

// The recording's attitudes at its accelerometer's samples, by magnetometer 0 and the parameters as
// they are; the parameters' dip is not used. mag_lag_s: how late the magnetometer is.
TrajectoryEstimate track(const Recording& recording, const SensorParameters& parameters,
                         double mag_lag_s = 0.0, const FilterOptions& options = {});

// Sensors taken at their word: no biases, no distortion. (The filter needs no field strength.)
inline SensorParameters uncalibrated() { return {}; }

// Of magnetometer 0; 0 where the calibration has none.
double magnetometer_lag_s(const Calibration& calibration);

}  // namespace magimu
