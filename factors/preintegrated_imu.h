// SPDX-License-Identifier: BSD-3-Clause
// Accelerometer and gyroscope samples between two nodes, integrated once (Forster et al. 2016): how
// far the sensor has turned, and what velocity and displacement its specific force adds up to in
// the frame of the first node; how all three change with the biases; and their covariance, which is
// linear in the squares of the two noise densities: these may change without integrating again.
//
//   w        = (I + S)^-1 (gyr - o_w)
//   delta_R' = delta_R Exp(w h)
//   delta_p' = delta_p + delta_v h + delta_R (f h^2 / 2 + w x f h^3 / 6 - f' h^3 / 12)
//   delta_v' = delta_v + delta_R J_l(w h) (f + w x f' h^2 / 12) h        f = acc - o_a
//
// with f the mean over the piece of a specific force that changes at the rate f' there: where the
// sensor turns meanwhile the mean of a product is not the product of the means (sculling: a sensor
// that turns at 3 rad/s and is read at 25 Hz would weigh 1e-3 of gravity too little). S are the
// gyroscope's scale errors and misalignment, where they are part of the model: all nine entries, in
// the accelerometer's frame, which is the IMU's. (A triangle would make the gyroscope's x axis and
// xy plane the IMU's; the accelerometer's gravity is then turned against them.) Errors in the order
// rotation (right), velocity, position: 9 numbers.
#pragma once

#include <Eigen/LU>
#include <optional>

#include "graph/rot3.h"

namespace magimu {

// S as a variable: its entries row by row, as those of the effect gyro_scale_misalignment.
using GyroMatrix = Vec<double, 9>;
inline Matrix3 square_matrix(const GyroMatrix& entries) {
  return entries.reshaped<Eigen::RowMajor>(3, 3);
}

class PreintegratedImu {
 public:
  using Matrix9 = Mat<double, 9, 9>;
  using Matrix9x3 = Mat<double, 9, 3>;

  // Biases at which to integrate, rad/s and m/s^2; and S, where it is part of the model.
  PreintegratedImu(const Vector3& gyr_bias, const Vector3& acc_bias,
                   const std::optional<GyroMatrix>& gyr_matrix = std::nullopt)
      : gyr_bias_(gyr_bias),
        acc_bias_(acc_bias),
        has_matrix_(gyr_matrix.has_value()),
        gyr_matrix_(gyr_matrix.value_or(GyroMatrix::Zero())),
        unscale_((Matrix3::Identity() + square_matrix(gyr_matrix_)).inverse()) {}

  // One more piece of h seconds: rate gyr, rad/s, held, and specific force acc, m/s^2, its mean.
  void integrate(const Vector3& gyr, const Vector3& acc, double h);
  // The same where gyr and acc have been corrected for effects with further parameters: by how much
  // gyr and acc fall as each of them grows. Every piece must have the same columns. acc_slope: at
  // which acc changes, m/s^3.
  using Columns = Eigen::Ref<const Eigen::Matrix<double, 3, Eigen::Dynamic>>;
  void integrate(const Vector3& gyr, const Vector3& acc, double h, const Columns& gyr_effects,
                 const Columns& acc_effects, const Vector3& acc_slope = Vector3::Zero());

  const Rot3& delta_R() const { return delta_R_; }
  const Vector3& delta_v() const { return delta_v_; }
  const Vector3& delta_p() const { return delta_p_; }
  double duration_s() const { return duration_s_; }
  const Vector3& gyr_bias() const { return gyr_bias_; }
  const Vector3& acc_bias() const { return acc_bias_; }
  // d (rotation, velocity, position) / d o_w and / d o_a.
  const Matrix9x3& gyr_bias_jacobian() const { return J_gyr_; }
  const Matrix9x3& acc_bias_jacobian() const { return J_acc_; }
  const GyroMatrix& gyr_matrix() const { return gyr_matrix_; }
  // d (rotation, velocity, position) / d S; 0 where S is not in the model.
  const Matrix9& gyr_matrix_jacobian() const { return J_matrix_; }
  // d (rotation, velocity, position) / d the effects' parameters, the gyroscope's first; 9 x 0
  // without.
  const Eigen::Matrix<double, 9, Eigen::Dynamic>& effect_jacobian() const { return J_effects_; }
  // Under white noise of these densities, rad/s and m/s^2 per sqrt(Hz).
  Matrix9 covariance(double gyr_density, double acc_density) const;

 private:
  Vector3 gyr_bias_, acc_bias_;
  bool has_matrix_;
  GyroMatrix gyr_matrix_;
  Matrix3 unscale_;  // (I + S)^-1
  Rot3 delta_R_;
  Vector3 delta_v_ = Vector3::Zero(), delta_p_ = Vector3::Zero();
  Matrix9x3 J_gyr_ = Matrix9x3::Zero(), J_acc_ = Matrix9x3::Zero();
  Matrix9 J_matrix_ = Matrix9::Zero();
  Eigen::Matrix<double, 9, Eigen::Dynamic> J_effects_;
  // Covariances for densities of one; the accelerometer's of velocity and position.
  Matrix9 unit_gyr_ = Matrix9::Zero();
  Mat<double, 6, 6> unit_acc_ = Mat<double, 6, 6>::Zero();
  double duration_s_ = 0.0;
};

}  // namespace magimu
