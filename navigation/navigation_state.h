// SPDX-License-Identifier: BSD-3-Clause
// What magnetic-field-aided inertial navigation estimates, and one step of it: strapdown
// integration of accelerometer and gyroscope together with the transport of the field model
// (field_transport.h), and the step's exact derivatives.
//
//   phi = (gyr - b_g) dt,  a = acc - b_a,  Delta = v dt + (R a + g) dt^2 / 2
//   p += Delta,  v += (R a + g) dt,  R <- R Exp(phi),  theta <- theta seen from there
//
// Frames: n has z up, g = (0, 0, -gravity); b is the body, with the IMU and the array. Errors are
// additive but for the attitude's, which is local: R_true = R Exp(eps), eps in b. (The library's
// factors perturb from the left; the literature on these filters does not, and its formulas for
// observability are easier to compare this way.)
#pragma once

#include "graph/rot3.h"
#include "navigation/field_transport.h"

namespace magimu {

struct NavigationState {
  Vector3 p = Vector3::Zero();         // position in n, m
  Vector3 v = Vector3::Zero();         // velocity in n, m/s
  Rot3 nRb;                            // attitude
  Vector3 acc_bias = Vector3::Zero();  // m/s^2
  Vector3 gyr_bias = Vector3::Zero();  // rad/s
  VectorXd theta;                      // coefficients of the field in b
};

// Where the parts of the error begin: 15 + kappa numbers.
namespace error_at {
inline constexpr int kPosition = 0, kVelocity = 3, kAttitude = 6, kAccBias = 9, kGyrBias = 12,
                     kField = 15;
}  // namespace error_at

// The state that departs from this one by an error.
NavigationState corrected(const NavigationState& state, const VectorXd& error);
// The error by which `other` departs from `state`: corrected(state, error) is `other`.
VectorXd error_between(const NavigationState& state, const NavigationState& other);

struct NavigationStep {
  NavigationState next;
  MatrixXd by_error;  // error after the step by the error before: F
  // By the white noise of acc and gyr: the same as by their biases (columns acc, then gyr).
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_noise;
  double distance_m = 0.0;  // |Delta|
  MatrixXd field_by_d;      // theta's derivative by the displacement in b
};

// acc m/s^2, gyr rad/s (the mean rate over the step), dt s, gravity m/s^2.
NavigationStep navigation_step(const NavigationState& state, const FieldTransport& transport,
                               const Vector3& acc, const Vector3& gyr, double dt, double gravity);

}  // namespace magimu
