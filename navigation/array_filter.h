// SPDX-License-Identifier: BSD-3-Clause
// Magnetic-field-aided inertial navigation (MAINS): an error-state Kalman filter that integrates
// accelerometer and gyroscope and holds them to the field that an array of magnetometers sees. The
// field model moves with the body (navigation_state.h), so what the array reads after a step tells
// how far the body moved and turned. Nothing tells position or yaw as such: both drift, slowly.
//
//   ArrayFilter filter(options, samples.positions);
//   filter.start(state);
//   for (...) {
//     filter.update(readings);
//     filter.propagate(acc, gyr, dt);
//   }
//
// navigate.h runs it over a recording.
#pragma once

#include <vector>

#include "navigation/navigation_state.h"

namespace magimu {

// Process noise of the field's coefficients. (Transport is exact for the model's polynomials, but
// not for the rest of the field.) One entry per coefficient.
struct FieldProcess {
  VectorXd
      step_sigma;  // standard deviation of white noise added per step, as in the published filters
  // A Gauss-Markov process over distance: standard deviation, and 0 for none. Such a coefficient
  // forgets what it was over memory_m, and keeps it while the body rests.
  VectorXd spread;
  double memory_m = 0.0;
};

struct ArrayFilterOptions {
  // Degree of the field's polynomials, 1 to 4 (4 needs an array that tells 35 coefficients apart).
  int order = 2;
  // OC-MAINS: keeps the uncertainty of yaw from shrinking, as nothing observes it
  // (observability.h).
  bool constrain_yaw = false;
  double gravity = 9.82;  // m/s^2
  // White noise, standard deviation a sample, m/s^2 and rad/s; and random walks of the biases, per
  // sqrt(s).
  double acc_noise = 0.05, gyr_noise = 0.5 * kDegreeInRad;
  double acc_walk = 1e-7, gyr_walk = 1e-7;
  // Standard deviations at the start: m, m/s, rad, m/s^2, rad/s, and uT/m^degree.
  double position_sigma = 0.01, velocity_sigma = 1.0, attitude_sigma = 5.0 * kDegreeInRad;
  double acc_bias_sigma = 0.5, gyr_bias_sigma = 0.5 * kDegreeInRad, field_sigma = 0.2;
  FieldProcess field = published_process(2);
  // True: take derivatives at gradients shrunk by the part of their size that comes from their
  // errors. False: at the estimated ones, as published; noise in a gradient then counts as
  // information about velocity.
  bool shrink_gradients = false;
  // The bias of every magnetometer but the last (whose bias is the field's) as further states,
  // with this standard deviation, uT; 0: none.
  double mag_bias_sigma = 0.0;

  static constexpr double kDegreeInRad = 0.017453292519943295;
  // The published white noise a step: of order 1 in units of the calibration site's field,
  // `strength_uT`; of order 2 in uT. Higher coefficients of higher orders as the last of order 2.
  static FieldProcess published_process(int order, double strength_uT = 1.0);
};

// The highest order of a field whose coefficients magnetometers at these places (m, frame of the
// sensor) tell apart with an equation to spare; 0: of none.
int highest_order(const std::vector<Vector3>& positions);

class ArrayFilter {
 public:
  // `positions`: of the magnetometers, m, in b. Throws InputError if they cannot distinguish the
  // field's coefficients.
  ArrayFilter(const ArrayFilterOptions& options, const std::vector<Vector3>& positions);

  // Coefficients that fit the readings best (3 M, uT).
  VectorXd fit_field(const VectorXd& readings) const;
  // Such a fit, with the variance of a reading's noise, uT^2, from its residuals.
  struct Fit {
    VectorXd theta;
    double variance = 0.0;
  };
  Fit fit(const VectorXd& readings) const;
  // Variances of such coefficients, for readings with noise of variance 1.
  VectorXd fit_variance() const;
  void start(const NavigationState& state);
  // The field at the start, by the first readings, uT. Published: the best fit, with field_sigma.
  // With a Gauss-Markov process: an update of the process's own spread; nothing is known of the
  // coefficients without one.
  void start_field(const VectorXd& readings);

  // One step of the IMU: acc m/s^2, gyr rad/s, dt s. linearize_field: coefficients at which the
  // derivatives are taken, instead of the estimated ones (studies know the true field).
  void propagate(const Vector3& acc, const Vector3& gyr, double dt,
                 const VectorXd* linearize_field = nullptr);

  // The magnetometers' readings, uT. Their noise is taken from the residuals of this sample's fit.
  struct Innovation {
    double nis = 0.0;  // of the field's coefficients: chi-square with `dof` numbers
    int dof = 0;
    double residual = 0.0;  // sum of squared residuals of the best fit, uT^2
    int residual_dof = 0;
    double log_density = 0.0;  // of the coefficients' innovation
  };
  Innovation update(const VectorXd& readings);
  // Updates with a position, m, known from another system.
  void aid_position(const Vector3& p, double sigma);

  const NavigationState& state() const { return state_; }
  const MatrixXd& covariance() const { return covariance_; }
  const VectorXd& mag_biases() const { return mag_bias_; }
  const FieldTransport& transport() const { return transport_; }

 private:
  void correct(const VectorXd& error);
  VectorXd shrunk_field() const;

  ArrayFilterOptions options_;
  FieldTransport transport_;
  MatrixXd phi_;                       // 3 M x kappa
  MatrixXd q_, r_;                     // phi_ = q_ r_
  NavigationState state_, predicted_;  // predicted_: state_ before its updates
  VectorXd mag_bias_;                  // 3 (M - 1) numbers, or none
  MatrixXd covariance_;                // of the error, then the magnetometers' biases
};

}  // namespace magimu
