// SPDX-License-Identifier: BSD-3-Clause
// How preintegrated motion changes with the parameters of effects on the samples, against
// integrating again.
#include <gtest/gtest.h>

#include "factors/preintegrated_gyroscope.h"
#include "factors/preintegrated_imu.h"
#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;
constexpr int kSamples = 25, kGyrEffects = 4, kAccEffects = 2;
constexpr double kDt = 0.01, kStep = 1e-5;

struct Samples {
  explicit Samples(unsigned seed) {
    test::RandomValue random(seed);
    for (int k = 0; k < kSamples; ++k) {
      gyr.push_back(random.vector3(2.0));
      acc.push_back(random.vector3(6.0));
      gyr_columns.push_back(Columns::NullaryExpr(3, kGyrEffects, [&] { return random.number(); }));
      acc_columns.push_back(Columns::NullaryExpr(3, kAccEffects, [&] { return random.number(); }));
    }
  }
  std::vector<Vector3> gyr, acc;
  std::vector<Columns> gyr_columns, acc_columns;
};

const Vector3 kGyrBias(0.02, -0.01, 0.03), kAccBias(0.1, 0.2, -0.1);

PreintegratedGyroscope integrate_gyroscope(const Samples& s, const VectorXd& theta) {
  PreintegratedGyroscope out(kGyrBias);
  for (std::size_t k = 0; k < s.gyr.size(); ++k) {
    out.integrate(s.gyr[k] - s.gyr_columns[k] * theta, kDt, s.gyr_columns[k]);
  }
  return out;
}

PreintegratedImu integrate_imu(const Samples& s, const VectorXd& theta, bool with_matrix) {
  std::optional<GyroMatrix> matrix;
  if (with_matrix) {
    matrix = (GyroMatrix() << 0.02, -0.01, 0.03, 0.01, 0.02, -0.02, 0.01, -0.03, 0.01).finished();
  }
  PreintegratedImu out(kGyrBias, kAccBias, matrix);
  for (std::size_t k = 0; k < s.gyr.size(); ++k) {
    out.integrate(s.gyr[k] - s.gyr_columns[k] * theta.head(kGyrEffects),
                  s.acc[k] - s.acc_columns[k] * theta.tail(kAccEffects), kDt, s.gyr_columns[k],
                  s.acc_columns[k]);
  }
  return out;
}

// The motion's error in the order of the Jacobian's rows: rotation (right), velocity, position.
Vec<double, 9> difference(const PreintegratedImu& at, const PreintegratedImu& other) {
  Vec<double, 9> d;
  d << (at.delta_R().inverse() * other.delta_R()).Log(), other.delta_v() - at.delta_v(),
      other.delta_p() - at.delta_p();
  return d;
}

TEST(PreintegratedGyroscope, effect_jacobian_agrees_with_integrating_again) {
  const Samples s(1);
  const VectorXd theta = VectorXd::LinSpaced(kGyrEffects, -0.1, 0.1);
  const PreintegratedGyroscope at = integrate_gyroscope(s, theta);
  ASSERT_EQ(at.effect_jacobian().cols(), kGyrEffects);
  for (int i = 0; i < kGyrEffects; ++i) {
    const VectorXd step = kStep * VectorXd::Unit(kGyrEffects, i);
    const Rot3 more = integrate_gyroscope(s, theta + step).delta();
    const Rot3 less = integrate_gyroscope(s, theta - step).delta();
    const Vector3 numerical =
        ((at.delta().inverse() * more).Log() - (at.delta().inverse() * less).Log()) / (2 * kStep);
    EXPECT_LT((at.effect_jacobian().col(i) - numerical).norm(), 1e-8) << i;
  }
}

TEST(PreintegratedImu, effect_jacobian_agrees_with_integrating_again) {
  const Samples s(2);
  const VectorXd theta = VectorXd::LinSpaced(kGyrEffects + kAccEffects, -0.1, 0.1);
  for (const bool with_matrix : {false, true}) {
    const PreintegratedImu at = integrate_imu(s, theta, with_matrix);
    ASSERT_EQ(at.effect_jacobian().cols(), theta.size());
    for (int i = 0; i < theta.size(); ++i) {
      const VectorXd step = kStep * VectorXd::Unit(theta.size(), i);
      const Vec<double, 9> numerical =
          (difference(at, integrate_imu(s, theta + step, with_matrix)) -
           difference(at, integrate_imu(s, theta - step, with_matrix))) /
          (2 * kStep);
      const Vec<double, 9> J = at.effect_jacobian().col(i), error = J - numerical;
      EXPECT_LT(error.head<3>().norm(), 1e-8) << i << " of " << with_matrix;
      // The turn within a piece, 0.02 rad here, is left out of the force's lever.
      EXPECT_LT(error.tail<6>().norm(), 0.02 * J.norm()) << i << " of " << with_matrix;
    }
  }
}

TEST(PreintegratedImu, effects_that_are_the_biases_have_their_jacobians) {
  const Samples s(3);
  PreintegratedImu imu(kGyrBias, kAccBias);
  PreintegratedGyroscope gyroscope(kGyrBias);
  const Columns one = Matrix3::Identity();
  for (std::size_t k = 0; k < s.gyr.size(); ++k) {
    imu.integrate(s.gyr[k], s.acc[k], kDt, one, one);
    gyroscope.integrate(s.gyr[k], kDt, one);
  }
  EXPECT_LT((imu.effect_jacobian().leftCols<3>() - imu.gyr_bias_jacobian()).norm(), 1e-14);
  EXPECT_LT((imu.effect_jacobian().rightCols<3>() - imu.acc_bias_jacobian()).norm(), 1e-14);
  EXPECT_LT((gyroscope.effect_jacobian() - gyroscope.bias_jacobian()).norm(), 1e-14);
}

}  // namespace
}  // namespace magimu
