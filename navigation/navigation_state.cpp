// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/navigation_state.h"

namespace magimu {

using namespace error_at;

NavigationState corrected(const NavigationState& state, const VectorXd& error) {
  NavigationState out = state;
  out.p += error.segment<3>(kPosition);
  out.v += error.segment<3>(kVelocity);
  out.nRb = (state.nRb * Rot3::Exp(error.segment<3>(kAttitude))).normalized();
  out.acc_bias += error.segment<3>(kAccBias);
  out.gyr_bias += error.segment<3>(kGyrBias);
  out.theta += error.segment(kField, state.theta.size());
  return out;
}

VectorXd error_between(const NavigationState& state, const NavigationState& other) {
  VectorXd error(kField + state.theta.size());
  error << other.p - state.p, other.v - state.v, (state.nRb.inverse() * other.nRb).Log(),
      other.acc_bias - state.acc_bias, other.gyr_bias - state.gyr_bias, other.theta - state.theta;
  return error;
}

NavigationStep navigation_step(const NavigationState& x, const FieldTransport& transport,
                               const Vector3& acc, const Vector3& gyr, double dt, double gravity) {
  const Vector3 g(0.0, 0.0, -gravity), a = acc - x.acc_bias, phi = (gyr - x.gyr_bias) * dt;
  const Matrix3 R = x.nRb.matrix(), I = Matrix3::Identity();
  const Vector3 a_n = R * a + g, moved_by = x.v * dt + a_n * (dt * dt / 2.0);
  const Rot3 E = Rot3::Exp(phi);
  const FieldTransport::Moved field = transport.move(x.theta, E, R.transpose() * moved_by);

  NavigationStep step;
  step.next = {x.p + moved_by, x.v + a_n * dt, (x.nRb * E).normalized(),
               x.acc_bias,     x.gyr_bias,     field.theta};
  step.distance_m = moved_by.norm();
  step.field_by_d = field.by_d;

  const Eigen::Index kappa = x.theta.size(), n = kField + kappa;
  const Matrix3 turned_force = R * so3::hat<double>(a), J = so3::right_jacobian<double>(phi);
  step.by_noise.setZero(n, 6);
  step.by_noise.block<3, 3>(kPosition, 0) = -R * (dt * dt / 2.0);
  step.by_noise.block<3, 3>(kVelocity, 0) = -R * dt;
  step.by_noise.block<3, 3>(kAttitude, 3) = -J * dt;
  step.by_noise.block(kField, 0, kappa, 3) = field.by_d * (-dt * dt / 2.0);
  step.by_noise.block(kField, 3, kappa, 3) = field.by_turn * J * -dt;

  MatrixXd& F = step.by_error;
  F.setIdentity(n, n);
  F.middleCols<6>(kAccBias) += step.by_noise;
  F.block<3, 3>(kPosition, kVelocity) = I * dt;
  F.block<3, 3>(kPosition, kAttitude) = -turned_force * (dt * dt / 2.0);
  F.block<3, 3>(kVelocity, kAttitude) = -turned_force * dt;
  F.block<3, 3>(kAttitude, kAttitude) = E.matrix().transpose();
  F.block(kField, kVelocity, kappa, 3) = field.by_d * R.transpose() * dt;
  F.block(kField, kAttitude, kappa, 3) =
      field.by_d * so3::hat<double>(R.transpose() * (x.v + g * (dt / 2.0)) * dt);
  F.bottomRightCorner(kappa, kappa) = field.by_theta;
  return step;
}

}  // namespace magimu
