// SPDX-License-Identifier: BSD-3-Clause
#include "factors/preintegrated_imu.h"

namespace magimu {
namespace {

// The transition of errors over one piece: [A 0 0; B I 0; B h / 2  h I].
struct Transition {
  Matrix3 A, B;
  double h;

  // F X, row by row of blocks.
  template <int N>
  void apply(Eigen::Matrix<double, 9, N>& X) const {
    const Eigen::Matrix<double, 3, N> turned = X.template topRows<3>(), faster = B * turned;
    X.template bottomRows<3>() += 0.5 * h * faster + h * X.template middleRows<3>(3);
    X.template middleRows<3>(3) += faster;
    X.template topRows<3>().noalias() = A * turned;
  }
};

}  // namespace

void PreintegratedImu::integrate(const Vector3& gyr, const Vector3& acc, double h) {
  static const Eigen::Matrix<double, 3, Eigen::Dynamic> none(3, 0);
  integrate(gyr, acc, h, none, none);
}

void PreintegratedImu::integrate(const Vector3& gyr, const Vector3& acc, double h,
                                 const Columns& gyr_effects, const Columns& acc_effects,
                                 const Vector3& acc_slope) {
  const Vector3 rate = unscale_ * (gyr - gyr_bias_), turn = rate * h;
  const Vector3 force = acc - acc_bias_;
  const Matrix3 R = delta_R_.matrix();
  const Rot3 step = Rot3::Exp(turn);
  const Matrix3 mean_R = R * so3::left_jacobian(turn);  // mean attitude over the piece
  const Matrix3 force_lever = R * so3::hat(force);

  const Transition F{step.matrix().transpose(), -force_lever * h, h};
  // How the two noises, constant over h seconds, enter the errors. A rate error turns the force
  // within the piece, too: by half of the turn on average.
  Mat<double, 6, 3> G_gyr;
  G_gyr << so3::right_jacobian(turn) * unscale_ * h, -force_lever * unscale_ * (0.5 * h * h);
  Mat<double, 6, 3> G_acc;
  G_acc << mean_R * h, R * (0.5 * h * h);

  F.apply(J_gyr_);
  J_gyr_.topRows<6>() -= G_gyr;
  F.apply(J_acc_);
  J_acc_.bottomRows<6>() -= G_acc;
  if (has_matrix_) {  // d w / d S_ij = -(I + S)^-1 e_i w_j
    F.apply(J_matrix_);
    for (int e = 0; e < 9; ++e) J_matrix_.col(e).head<6>() -= G_gyr.col(e / 3) * rate[e % 3];
  }
  if (const Eigen::Index n = gyr_effects.cols() + acc_effects.cols(); n > 0) {
    if (J_effects_.cols() == 0) J_effects_.setZero(9, n);
    F.apply(J_effects_);
    J_effects_.topLeftCorner(6, gyr_effects.cols()) -= G_gyr * gyr_effects;
    J_effects_.bottomRightCorner(6, acc_effects.cols()) -= G_acc * acc_effects;
  }
  // F P F'. A density d over h seconds is white noise of variance d^2 / h on the held value. The
  // accelerometer's turns nothing.
  F.apply(unit_gyr_);
  unit_gyr_.transposeInPlace();
  F.apply(unit_gyr_);
  unit_gyr_.topLeftCorner<6, 6>() += G_gyr * G_gyr.transpose() / h;
  unit_acc_.bottomRows<3>() += h * unit_acc_.topRows<3>();
  unit_acc_.rightCols<3>() += h * unit_acc_.leftCols<3>();
  unit_acc_ += G_acc * G_acc.transpose() / h;

  delta_p_ += delta_v_ * h +
              R * (0.5 * force + h / 6.0 * rate.cross(force) - h / 12.0 * acc_slope) * (h * h);
  delta_v_ += mean_R * (force + h * h / 12.0 * rate.cross(acc_slope)) * h;
  delta_R_ = (delta_R_ * step).normalized();
  duration_s_ += h;
}

PreintegratedImu::Matrix9 PreintegratedImu::covariance(double gyr_density,
                                                       double acc_density) const {
  Matrix9 out = unit_gyr_ * (gyr_density * gyr_density);
  out.bottomRightCorner<6, 6>() += unit_acc_ * (acc_density * acc_density);
  return out;
}

}  // namespace magimu
