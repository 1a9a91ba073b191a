// SPDX-License-Identifier: BSD-3-Clause
#include "factors/preintegrated_imu.h"

namespace magimu {
namespace {

// The transition of errors over one piece: [A 0 0; B I 0; B h / 2  h I].
struct Transition {
  Matrix3 A, B;
  double h;

  // F X, row by row of blocks.
  template <class Columns>
  void apply(Columns& X) const {
    constexpr int N = Columns::ColsAtCompileTime;
    const Eigen::Matrix<double, 3, N> turned = X.template topRows<3>(), faster = B * turned;
    X.template bottomRows<3>() += 0.5 * h * faster + h * X.template middleRows<3>(3);
    X.template middleRows<3>(3) += faster;
    X.template topRows<3>().noalias() = A * turned;
  }
  // Of any number of columns, three at a time: short loops of known length are much faster.
  void apply_to(Eigen::Matrix<double, 9, Eigen::Dynamic>& X, Eigen::Index count) const {
    Eigen::Index c = 0;
    for (; c + 3 <= count; c += 3) {
      Eigen::Map<Mat<double, 9, 3>> three(X.col(c).data());
      apply(three);
    }
    for (; c < count; ++c) {
      Eigen::Map<Vec<double, 9>> one(X.col(c).data());
      apply(one);
    }
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
  J_acc_.bottomRows<3>() += h * J_acc_.middleRows<3>(3);  // it turns nothing
  J_acc_.bottomRows<6>() -= G_acc;
  if (has_matrix_) {  // d w / d S_ij = -(I + S)^-1 e_i w_j
    F.apply(J_matrix_);
    for (int e = 0; e < 9; ++e) J_matrix_.col(e).head<6>() -= G_gyr.col(e / 3) * rate[e % 3];
  }
  if (const Eigen::Index n = gyr_effects.cols() + acc_effects.cols(); n > 0) {
    if (J_effects_.cols() == 0) J_effects_.setZero(9, n);
    const Eigen::Index of_gyr = gyr_effects.cols(), of_acc = acc_effects.cols();
    F.apply_to(J_effects_, of_gyr);
    J_effects_.topLeftCorner(6, of_gyr).noalias() -= G_gyr.lazyProduct(gyr_effects);
    auto acc_part = J_effects_.rightCols(of_acc);
    acc_part.bottomRows<3>() += h * acc_part.middleRows<3>(3);
    acc_part.bottomRows<6>().noalias() -= G_acc.lazyProduct(acc_effects);
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
