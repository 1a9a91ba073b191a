// SPDX-License-Identifier: BSD-3-Clause
// An array's recording in, a trajectory with its covariance out.
#pragma once

#include <optional>
#include <vector>

#include "navigation/array_filter.h"
#include "navigation/array_samples.h"

namespace magimu {

struct NavigationStart {
  Vector3 p = Vector3::Zero(), v = Vector3::Zero();
  Rot3 nRb;
};

struct NavigationOptions {
  ArrayFilterOptions filter;
  // None: at the origin, at rest, yaw 0, roll and pitch by the first sample of the accelerometer.
  std::optional<NavigationStart> start;
  bool use_magnetometers = true;  // false: inertial navigation alone
  // Seconds from the start during which the true position aids the filter, and its standard
  // deviation, m.
  double aided_s = 0.0, aid_sigma = 0.01;
  // For studies: the field's coefficients at each sample at which the filter takes its derivatives;
  // none: the estimated ones.
  std::vector<VectorXd> linearize_field;
};

struct NavigationRun {
  std::vector<double> t;
  std::vector<NavigationState> states;                     // after the update at that time
  std::vector<Eigen::Matrix<double, 15, 15>> covariances;  // of p, v, attitude (local), biases
  std::vector<ArrayFilter::Innovation> innovations;        // of the updates
  double seconds = 0.0;                                    // of the processor
};

// Throws InputError if the layout does not permit the order, or if the filter diverged (for example
// with readings that are not in uT).
NavigationRun navigate(const ArraySamples& samples, const NavigationOptions& options);

}  // namespace magimu
