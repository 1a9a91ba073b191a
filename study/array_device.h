// SPDX-License-Identifier: BSD-3-Clause
// A board of many magnetometers on one IMU: its calibration by each method from a simulated
// recording of it being turned, and what its readings of a known field would have been before
// calibration, so that navigation can be tried with each calibration.
#pragma once

#include "study/method_runs.h"

namespace magimu {

struct ArrayDeviceOptions {
  std::uint64_t seed = 1;
  int magnetometers = 30;
  SimulatedMotion motion = SimulatedMotion::kPaper;
  double rate_hz = 62.5, duration_s = 0.0;  // of the turning; 0: the motion's own
  // Of the real board in the published recording: IMU (mean of 32) and magnetometers.
  NoiseDensities noise{0.002, 1e-4, 0.005};
  int node_every = 3;  // as published
};

struct ArrayDevice {
  ArrayDeviceOptions options;
  Simulation simulation;
};
ArrayDevice make_device(const ArrayDeviceOptions& options);

struct ArrayCalibration {
  Calibration calibration;  // parameters of all magnetometers; covariance where it is joint
  double seconds = 0.0;     // of the processor
  int calibrated = 0;       // magnetometers, the first ones; all but in the slowest method
  std::string error;
};
// The MAP, Kok and Wu of all magnetometers jointly; as published, each magnetometer by itself with
// the IMU. `most`: only the first of them (the others are as the last one).
ArrayCalibration calibrate_array(const ArrayDevice& device, Method method, int most);
// The MAP of each magnetometer by itself.
ArrayCalibration calibrate_pairs(const ArrayDevice& device, int most);
ArrayCalibration exact_calibration(const ArrayDevice& device);
// D of the field's strength times the identity, no bias.
ArrayCalibration no_calibration(const ArrayDevice& device);

// Root mean square over the calibrated magnetometers.
struct ArrayErrors {
  double mag_bias_uT = kNoValue, distortion_uT = kNoValue;
  double mag_bias_sigma_uT = kNoValue, distortion_sigma_uT = kNoValue;  // claimed, of joint ones
  double acc_bias = kNoValue, gyr_bias = kNoValue;
};
ArrayErrors array_errors(const ArrayDevice& device, const ArrayCalibration& made);

// Readings (uT, in the axes of the IMU) as the board's magnetometers give them, and such readings
// with a calibration taken out: the other way round where it is exact.
Recording as_measured(const ArrayDevice& device, const Recording& exact);
Recording corrected(const ArrayCalibration& made, const Recording& measured);

}  // namespace magimu
