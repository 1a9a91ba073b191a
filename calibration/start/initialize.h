// SPDX-License-Identifier: BSD-3-Clause
// Step 1 of Algorithm 1 (Huang et al. 2025): where the optimization starts. Gyroscope bias from
// rests, refined with the field's turning; distortion from the ellipsoid and the alignment; the
// attitude of every node from gravity and the field; the dip from the data, unless given.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/model/model.h"

namespace magimu {

// A start made worse on purpose, for tests of convergence: does a blind start end in the same
// minimum? Signs, axes and directions are drawn by the seed.
struct StartPerturbation {
  std::uint64_t seed = 0;
  double tilt_rad = 0.0, heading_rad = 0.0;  // of every attitude, all alike
  double distortion = 0.0;                   // of each D, as a share of its Frobenius norm
  double mag_bias_uT = 0.0;                  // length, of each magnetometer's
};

struct InitializationOptions {
  std::optional<Vector3> gyr_bias;  // the fit starts here; only the alignment looks on, rad/s
  bool trust_gyr_bias = false;      // the alignment, too, takes it as it is, if it is given
  std::optional<double> dip_rad;    // start here
  // Start here, but for the dip: nothing is sought in the readings then.
  std::optional<SensorParameters> parameters;
  std::optional<StartPerturbation> perturbation;  // none, but in tests
};

struct InitialGuess {
  SensorParameters parameters;  // dip_rad: of the first recording
  std::vector<double> dip_rad;  // one a field (fields_of())
  double alignment_rms_rad = 0.0;
  double ellipsoid_rms_uT = 0.0;
  Rot3 attitude_error;  // turns every attitude that these parameters give; the identity, but in
                        // tests
};

InitialGuess initialize(const std::vector<const Recording*>& recordings,
                        const InitializationOptions& options);

// All variables of a model at the guess; velocities and positions at zero.
Values initial_values(const std::vector<const Recording*>& recordings,
                      const std::vector<NodePlan>& plans, const InitialGuess& guess,
                      MotionModel motion);

}  // namespace magimu
