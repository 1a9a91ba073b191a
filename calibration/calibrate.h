// SPDX-License-Identifier: BSD-3-Clause
// Calibration of an accelerometer, a gyroscope and one or more magnetometers from recordings of
// someone turning them: Algorithm 1 of Huang et al. 2025, initialization and joint maximum a
// posteriori estimate of trajectory and parameters, with the noise estimated where it is not given,
// and with a verdict.
//
//   const Recording recording = read_recording("hand_rotation.csv");
//   const Calibration calibration = calibrate(recording);
//   if (calibration.trust.verdict == Verdict::kNo) ...
//   const MagnetometerParameters& mag = calibration.parameters.mag[0];
//   const Vector3 field = mag.distortion.inverse() * (reading - mag.bias);
#pragma once

#include <vector>

#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"
#include "recording/data/recording.h"

namespace magimu {

// Throws InputError where a recording is none (recording/data/well_formed.h), a sensor has no
// samples, or samples are not what they seem to be; everything else is told by the result's trust,
// also that no fit could be made. Where the magnetometer's bias changes within a single recording
// (a magnet was attached), and what follows, or is outside of that time, tells more than all does,
// the result is that of those samples, and its first warning says so.
Calibration calibrate(const Recording& recording, const CalibrationOptions& options = {});
Calibration calibrate(const std::vector<const Recording*>& recordings,
                      const CalibrationOptions& options = {});

}  // namespace magimu
