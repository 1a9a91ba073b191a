// SPDX-License-Identifier: BSD-3-Clause
// The filter of Wu et al. (Dynamic magnetometer calibration and alignment to inertial sensors by
// Kalman filtering, arXiv 1612.01044): an extended Kalman filter over the orientation and all
// calibration parameters, which pass through the samples once. Two forms:
//
//   sound      the reference frame is n, by gravity and field: 3 + 19 states without a gauge; no
//              noise on constants; repeated from the parameters it ended with until they stay
//   published  as code published with Huang et al. 2025 runs it: the first body frame is the
//              reference, so that field and gravity are states of their own, and with the scale
//              four gauge directions are held by priors and by noise on constants
#pragma once

#include "calibration/rivals/kok_problem.h"

namespace magimu {

struct WuEstimate {
  SensorParameters theta;
  std::vector<double> dip_rad;
  MatrixXd covariance;                 // of o_a, o_w, D and o_m of each magnetometer, dips (rad)
  std::vector<std::vector<Rot3>> nRb;  // filtered, at each step of each recording
  double squares = 0.0;                // sum of e' S^-1 e of the last pass
  long rows = 0;
  int passes = 0;
  double last_change = 0.0;  // between the last two passes, standard deviations
  double seconds = 0.0;
};

struct WuOptions {
  NoiseDensities noise;  // per sqrt(Hz)
  double gravity = kStandardGravity;
  int max_passes = 8;
};

// guess: where the first pass starts. Its uncertainty is taken so wide that it adds no information.
WuEstimate wu_filter(const std::vector<const Recording*>& recordings, const SensorParameters& guess,
                     const std::vector<double>& dip_rad, const WuOptions& options);

// One recording. gyr_bias: nominal.
WuEstimate wu_published(const Recording& recording, const Vector3& gyr_bias,
                        const WuOptions& options);

}  // namespace magimu
