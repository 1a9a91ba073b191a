// SPDX-License-Identifier: BSD-3-Clause
// How far an estimated trajectory is from an independent truth (cameras, a simulator): for tests
// and benchmarks.
#pragma once

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu {

struct OrientationError {
  double total_deg = 0.0;        // RMS angle of the rotation between estimate and truth
  double heading_deg = 0.0;      // RMS of its part about the vertical
  double inclination_deg = 0.0;  // RMS angle between the two verticals
  int compared = 0;              // nodes with a valid truth
};

// Truth and estimate in the same frame n; at each node the truth's sample nearest in time (at most
// 10 ms away), where it is valid.
OrientationError orientation_error(const TrajectoryEstimate& estimate, const MotionTruth& truth);

}  // namespace magimu
