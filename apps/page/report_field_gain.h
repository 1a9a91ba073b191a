// SPDX-License-Identifier: BSD-3-Clause
// What a calibration is worth, in two numbers before and after: how much the length of a
// magnetometer's readings scatters, and how far the heading that they give is from that of the
// estimated motion.
#pragma once

#include <vector>

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu::apps {

struct FieldGain {
  double length_before = 0.0,
         length_after = 0.0;  // RMS deviation of the length from its mean, as a share of the mean
  double heading_before_deg = 0.0, heading_after_deg = 0.0;  // RMS
};

// NaN if the recordings have no readings or no trajectory.
FieldGain field_gain(const Calibration& calibration,
                     const std::vector<const Recording*>& recordings, std::size_t magnetometer);

}  // namespace magimu::apps
