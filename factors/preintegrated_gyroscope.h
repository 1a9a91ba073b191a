// SPDX-License-Identifier: BSD-3-Clause
// Gyroscope samples between two nodes, integrated once: the relative rotation, how it changes with
// the bias, and its covariance (Huang et al. 2025, eq. (preintegration) and appendix C, after
// Forster et al. 2016). The nodes are every N samples: 0, N, 2N, ...
#pragma once

#include "graph/rot3.h"

namespace magimu {

class PreintegratedGyroscope {
 public:
  // bias: the gyroscope bias at which to integrate, rad/s.
  explicit PreintegratedGyroscope(const Vector3& bias) : bias_(bias) {}
  // Integrated elsewhere, without a covariance.
  PreintegratedGyroscope(const Vector3& bias, const Rot3& delta, const Matrix3& bias_jacobian,
                         double duration_s)
      : bias_(bias), delta_(delta), bias_jacobian_(bias_jacobian), duration_s_(duration_s) {}

  // One more sample (or part of one): the rate gyr, rad/s, held for dt_s seconds. effects: by how
  // much gyr, which has been corrected for effects, falls as each of their parameters grows; every
  // sample must have the same columns.
  using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  void integrate(const Vector3& gyr, double dt_s,
                 const Eigen::Ref<const Columns>& effects = Columns(3, 0)) {
    const Vector3 v = (gyr - bias_) * dt_s;
    const Rot3 step = Rot3::Exp(v);
    const Matrix3 undo = step.matrix().transpose();
    const Matrix3 J = so3::right_jacobian(v);
    if (effects.cols() > 0) {
      // Many columns, so summed in the first frame, where no step turns them; J' is the left one.
      if (turned_.cols() == 0) turned_.setZero(3, effects.cols());
      turned_.noalias() += Matrix3(delta_.matrix() * J.transpose() * dt_s) * effects;
    }
    delta_ = (delta_ * step).normalized();
    bias_jacobian_ = undo * bias_jacobian_ - J * dt_s;
    covariance_ = undo * covariance_ * undo.transpose() + J * J.transpose() * dt_s;
    duration_s_ += dt_s;
  }

  // Rotation from the later IMU frame to the earlier: R_i' R_j.
  const Rot3& delta() const { return delta_; }
  const Vector3& bias() const { return bias_; }
  // delta(bias + d) ~ delta(bias) Exp(bias_jacobian() d).
  const Matrix3& bias_jacobian() const { return bias_jacobian_; }
  // The same for the effects' parameters.
  Columns effect_jacobian() const { return -delta_.matrix().transpose() * turned_; }
  // Covariance of the rotation error (right, rad^2) for a noise density of 1 rad/s per sqrt(Hz);
  // the density's square scales it.
  const Matrix3& unit_covariance() const { return covariance_; }
  double duration_s() const { return duration_s_; }

 private:
  Vector3 bias_;
  Rot3 delta_;
  Matrix3 bias_jacobian_ = Matrix3::Zero();
  Columns turned_ = Columns(3, 0);  // by the effects, in the first frame
  Matrix3 covariance_ = Matrix3::Zero();
  double duration_s_ = 0.0;
};

}  // namespace magimu
