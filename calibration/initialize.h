// SPDX-License-Identifier: BSD-3-Clause
// Step 1 of Algorithm 1 (Huang et al. 2025): where the optimization starts. Gyroscope bias from
// rests, refined with the field's turning; distortion from the ellipsoid and the alignment; the
// attitude of every node from gravity and the field; the dip from the data, unless given.
#pragma once

#include <optional>
#include <vector>

#include "calibration/model.h"

namespace magimu {

struct InitializationOptions {
  std::optional<Vector3> gyr_bias;  // start here and do not look for a better start, rad/s
  std::optional<double> dip_rad;    // start here
};

struct InitialGuess {
  SensorParameters parameters;  // dip_rad: of the first recording
  std::vector<double> dip_rad;  // one a recording
  double alignment_rms_rad = 0.0;
  double ellipsoid_rms_uT = 0.0;
};

InitialGuess initialize(const std::vector<const Recording*>& recordings,
                        const InitializationOptions& options);

// All variables of a model at the guess; velocities and positions at zero.
Values initial_values(const std::vector<const Recording*>& recordings,
                      const std::vector<NodePlan>& plans, const InitialGuess& guess,
                      MotionModel motion);

}  // namespace magimu
