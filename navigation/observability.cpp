// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/observability.h"

namespace magimu {
namespace {

using namespace error_at;

// The matrix nearest to X (Frobenius) with X u = w.
template <class Matrix>
Matrix nearest_with(const Matrix& X, const Vector3& u, const Vector3& w) {
  return X - (X * u - w) * u.transpose() / u.squaredNorm();
}

// The rotation nearest to Q that turns u into w, both of one length: Q, then the least turn from
// Q u to w.
Matrix3 nearest_turn_with(const Matrix3& Q, const Vector3& u, const Vector3& w) {
  const Eigen::Quaterniond least = Eigen::Quaterniond::FromTwoVectors(Q * u, w);
  return least.toRotationMatrix() * Q;
}

}  // namespace

VectorXd yaw_direction(const NavigationState& predicted, double gravity) {
  const Vector3 g(0.0, 0.0, -gravity);
  VectorXd u = VectorXd::Zero(kField + predicted.theta.size());
  u.segment<3>(kVelocity) = -predicted.v.cross(g);
  u.segment<3>(kAttitude) = predicted.nRb.unrotate(g);
  return u;
}

void constrain_yaw(NavigationStep& step, const NavigationState& predicted,
                   const NavigationState& updated, const Vector3& phi, double dt, double gravity) {
  const Vector3 g(0.0, 0.0, -gravity), u = predicted.nRb.unrotate(g);
  MatrixXd& F = step.by_error;
  const Matrix3 R = updated.nRb.matrix();

  const Matrix3 velocity = F.block<3, 3>(kVelocity, kAttitude);
  F.block<3, 3>(kVelocity, kAttitude) =
      nearest_with(velocity, u, Vector3(-(step.next.v - predicted.v).cross(g)));

  // [R'(v + g dt/2)]x = R' [v + g dt/2]x R.
  const Matrix3 displacement = so3::hat<double>(updated.v + g * (dt / 2.0)) * R;
  F.middleRows(kField, updated.theta.size()).middleCols<3>(kAttitude) =
      step.field_by_d * R.transpose() * dt *
      nearest_with(displacement, u, Vector3(predicted.v.cross(g)));

  F.block<3, 3>(kAttitude, kAttitude) =
      nearest_turn_with(Rot3::Exp(-phi).matrix(), u, step.next.nRb.unrotate(g));
}

}  // namespace magimu
