// SPDX-License-Identifier: BSD-3-Clause
// A first estimate of the attitude at any time, without recursion: over some seconds around it the
// gyroscope relates all readings to one frame, their means give gravity and the field there, and
// the two directions fix the attitude (TRIAD). Accelerations of the hand average out; errors of the
// gyroscope bias cancel to first order because the span is symmetric; no sample is special, so no
// particular start (level, facing north) is assumed.
#pragma once

#include <vector>

#include "calibration/motion/integrated_rotation.h"
#include "factors/sensor_model.h"

namespace magimu {

struct AttitudeOptions {
  double half_span_s = 1.0;  // means are taken over twice this
};

// nRb at each of the given times, which increase. parameters: of the recording's magnetometer 0
// (if the recording has none, headings are those of the gyroscope alone).
std::vector<Rot3> estimate_attitudes(const Recording& recording, const SensorParameters& parameters,
                                     const IntegratedRotation& gyr, const std::vector<double>& t,
                                     const AttitudeOptions& options = {});

// The dip that gravity and the field, so averaged, enclose; rad.
double estimate_dip(const Recording& recording, const SensorParameters& parameters,
                    const IntegratedRotation& gyr, const AttitudeOptions& options = {});

}  // namespace magimu
