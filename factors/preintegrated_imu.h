// SPDX-License-Identifier: BSD-3-Clause
// Accelerometer and gyroscope samples between two nodes, integrated once (Forster et al. 2016): how
// far the sensor has turned, and what velocity and displacement its specific force adds up to in
// the frame of the first node; how all three change with the biases; and their covariance.
//
//   delta_R' = delta_R Exp((w - o_w) h)
//   delta_p' = delta_p + delta_v h + delta_R (a - o_a) h^2 / 2
//   delta_v' = delta_v + delta_R J_l((w - o_w) h) (a - o_a) h
//
// Errors in the order rotation (right), velocity, position: 9 numbers.
#pragma once

#include "graph/rot3.h"

namespace magimu {

class PreintegratedImu {
 public:
  using Matrix9 = Mat<double, 9, 9>;
  using Matrix9x3 = Mat<double, 9, 3>;

  // Biases at which to integrate, rad/s and m/s^2, and noise densities per sqrt(Hz).
  PreintegratedImu(const Vector3& gyr_bias, const Vector3& acc_bias, double gyr_density,
                   double acc_density)
      : gyr_bias_(gyr_bias),
        acc_bias_(acc_bias),
        gyr_variance_(gyr_density * gyr_density),
        acc_variance_(acc_density * acc_density) {}

  // One more piece: rate gyr, rad/s, and specific force acc, m/s^2, held for h seconds.
  void integrate(const Vector3& gyr, const Vector3& acc, double h);

  const Rot3& delta_R() const { return delta_R_; }
  const Vector3& delta_v() const { return delta_v_; }
  const Vector3& delta_p() const { return delta_p_; }
  double duration_s() const { return duration_s_; }
  const Vector3& gyr_bias() const { return gyr_bias_; }
  const Vector3& acc_bias() const { return acc_bias_; }
  // d (rotation, velocity, position) / d o_w and / d o_a.
  const Matrix9x3& gyr_bias_jacobian() const { return J_gyr_; }
  const Matrix9x3& acc_bias_jacobian() const { return J_acc_; }
  const Matrix9& covariance() const { return covariance_; }

 private:
  Vector3 gyr_bias_, acc_bias_;
  double gyr_variance_, acc_variance_;
  Rot3 delta_R_;
  Vector3 delta_v_ = Vector3::Zero(), delta_p_ = Vector3::Zero();
  Matrix9x3 J_gyr_ = Matrix9x3::Zero(), J_acc_ = Matrix9x3::Zero();
  Matrix9 covariance_ = Matrix9::Zero();
  double duration_s_ = 0.0;
};

}  // namespace magimu
