// SPDX-License-Identifier: BSD-3-Clause
#include "factors/preintegrated_imu.h"

namespace magimu {

void PreintegratedImu::integrate(const Vector3& gyr, const Vector3& acc, double h) {
  const Vector3 turn = (gyr - gyr_bias_) * h;
  const Vector3 force = acc - acc_bias_;
  const Matrix3 R = delta_R_.matrix();
  const Rot3 step = Rot3::Exp(turn);
  const Matrix3 J_r = so3::right_jacobian(turn);
  const Matrix3 mean_R = R * so3::left_jacobian(turn);  // mean attitude over the piece
  const Matrix3 force_lever = R * so3::hat(force);

  // Error transition F and the ways in of the two noises.
  Matrix9 F = Matrix9::Identity();
  F.block<3, 3>(0, 0) = step.matrix().transpose();
  F.block<3, 3>(3, 0) = -force_lever * h;
  F.block<3, 3>(6, 0) = -force_lever * (0.5 * h * h);
  F.block<3, 3>(6, 3) = Matrix3::Identity() * h;
  Matrix9x3 G_gyr = Matrix9x3::Zero(), G_acc = Matrix9x3::Zero();
  G_gyr.topRows<3>() = J_r * h;
  // A rate error turns the force within the piece, too: half of it by its middle.
  G_gyr.middleRows<3>(3) = -force_lever * (0.5 * h * h);
  G_acc.middleRows<3>(3) = mean_R * h;
  G_acc.bottomRows<3>() = R * (0.5 * h * h);

  J_gyr_ = F * J_gyr_ - G_gyr;
  J_acc_ = F * J_acc_ - G_acc;
  // A density d over h seconds is white noise of variance d^2 / h on the held value.
  covariance_ = F * covariance_ * F.transpose() + G_gyr * G_gyr.transpose() * (gyr_variance_ / h) +
                G_acc * G_acc.transpose() * (acc_variance_ / h);

  delta_p_ += delta_v_ * h + R * force * (0.5 * h * h);
  delta_v_ += mean_R * force * h;
  delta_R_ = (delta_R_ * step).normalized();
  duration_s_ += h;
}

}  // namespace magimu
