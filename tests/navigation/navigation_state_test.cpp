// SPDX-License-Identifier: BSD-3-Clause
// One step of navigation: its derivatives, and the observability constraint on them.
#include "navigation/navigation_state.h"

#include <gtest/gtest.h>

#include <random>

#include "navigation/observability.h"

namespace magimu {
namespace {

struct Case {
  explicit Case(int order, unsigned seed = 3) : transport(order) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&](double size) {
      return Vector3(size * Vector3(normal(engine), normal(engine), normal(engine)));
    };
    state = {vector(1.0), vector(1.0), Rot3::Exp(vector(1.0)), vector(0.1), vector(0.05), {}};
    state.theta = VectorXd::NullaryExpr(transport.basis().size(), [&] { return normal(engine); });
    acc = vector(5.0);
    gyr = vector(2.0);
  }
  NavigationStep step(const NavigationState& from) const {
    return navigation_step(from, transport, acc, gyr, kDt, kGravity);
  }
  static constexpr double kDt = 0.05, kGravity = 9.82;
  FieldTransport transport;
  NavigationState state;
  Vector3 acc, gyr;
};

TEST(NavigationStep, jacobians_are_the_numerical_ones) {
  constexpr double kStep = 1e-5;
  for (int order = 1; order <= 4; ++order) {
    const Case c(order);
    const NavigationStep step = c.step(c.state);
    const Eigen::Index n = step.by_error.cols();
    for (Eigen::Index i = 0; i < n; ++i) {
      const VectorXd h = kStep * VectorXd::Unit(n, i);
      const VectorXd numerical = (error_between(step.next, c.step(corrected(c.state, h)).next) -
                                  error_between(step.next, c.step(corrected(c.state, -h)).next)) /
                                 (2.0 * kStep);
      EXPECT_LT((step.by_error.col(i) - numerical).cwiseAbs().maxCoeff(), 1e-6)
          << "order " << order << ", error " << i;
    }
  }
}

TEST(NavigationStep, noise_acts_as_the_biases_do) {
  constexpr double kStep = 1e-5;
  const Case c(2);
  const NavigationStep step = c.step(c.state);
  for (int i = 0; i < 6; ++i) {
    // A reading that is too large by h: the true force and rate are smaller by it.
    Case more = c, less = c;
    (i < 3 ? more.acc[i] : more.gyr[i - 3]) -= kStep;
    (i < 3 ? less.acc[i] : less.gyr[i - 3]) += kStep;
    const VectorXd numerical = (error_between(step.next, more.step(c.state).next) -
                                error_between(step.next, less.step(c.state).next)) /
                               (2.0 * kStep);
    EXPECT_LT((step.by_noise.col(i) - numerical).cwiseAbs().maxCoeff(), 1e-6) << i;
  }
}

// Errors without the position.
VectorXd but_position(const VectorXd& error) { return error.tail(error.size() - 3); }

TEST(Observability, without_updates_the_derivatives_keep_yaws_direction) {
  const Case c(2);
  const NavigationStep step = c.step(c.state);
  const VectorXd mapped = step.by_error * yaw_direction(c.state, c.kGravity);
  EXPECT_LT(but_position(mapped - yaw_direction(step.next, c.kGravity)).norm(), 1e-10);
}

TEST(Observability, constrained_derivatives_keep_it_after_an_update_too) {
  for (int order = 1; order <= 3; ++order) {
    const Case c(order);
    const Vector3 phi = (c.gyr - c.state.gyr_bias) * c.kDt;
    VectorXd error = VectorXd::Constant(15 + c.state.theta.size(), 0.03);
    const NavigationState predicted = corrected(c.state, error);
    NavigationStep step = c.step(c.state);
    const MatrixXd free = step.by_error;
    const VectorXd before = yaw_direction(predicted, c.kGravity);
    EXPECT_GT(but_position(free * before - yaw_direction(step.next, c.kGravity)).norm(), 1e-3);
    constrain_yaw(step, predicted, c.state, phi, c.kDt, c.kGravity);
    EXPECT_LT(but_position(step.by_error * before - yaw_direction(step.next, c.kGravity)).norm(),
              1e-10);
    // Only columns of the attitude change, and the turn stays one.
    EXPECT_EQ((step.by_error - free).cwiseAbs().colwise().maxCoeff().maxCoeff(),
              (step.by_error - free).middleCols<3>(6).cwiseAbs().maxCoeff());
    const Matrix3 turn = step.by_error.block<3, 3>(6, 6);
    EXPECT_LT((turn * turn.transpose() - Matrix3::Identity()).norm(), 1e-12);
  }
}

TEST(Observability, the_constraint_changes_nothing_where_nothing_was_updated) {
  const Case c(2);
  NavigationStep step = c.step(c.state);
  const MatrixXd free = step.by_error;
  constrain_yaw(step, c.state, c.state, (c.gyr - c.state.gyr_bias) * c.kDt, c.kDt, c.kGravity);
  EXPECT_LT((step.by_error - free).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace magimu
