// SPDX-License-Identifier: BSD-3-Clause
// The calculus of rotations against an oracle that shares nothing with it: power series of
// matrices, summed in long double.
#include "graph/so3.h"

#include <Eigen/LU>

#include "graph/dual.h"
#include "tests/graph/directions.h"

namespace magimu {
namespace {

using Long3 = Mat3<long double>;

// sum over n of [v]^n sign^n / (n + shift)!: the exponential for shift 0, the Jacobians for 1.
Long3 series(const Vector3& v, long double sign, int shift) {
  const Vec3<long double> w = v.cast<long double>() * sign;
  const Long3 W = so3::hat(w);
  Long3 sum = Long3::Identity(), term = Long3::Identity();
  for (int n = 1; n < 60; ++n) {
    term = (term * W / (long double)(n + shift)).eval();
    sum += term;
  }
  return sum;
}

double error(const Matrix3& given, const Long3& expected) {
  return double((given.cast<long double>() - expected).cwiseAbs().maxCoeff());
}

const std::vector<double> kTurns = {0.0,   1e-160, 1e-12, 1e-8, 1e-4, 0.03,  0.1,      0.316,
                                    0.317, 0.5,    1.0,   2.0,  3.0,  3.141, test::kPi};

TEST(So3, jacobians_agree_with_power_series_in_long_double) {
  for (const double angle : kTurns) {
    for (const Vector3& n : test::directions()) {
      const Vector3 v = n * angle;
      const Long3 right = series(v, -1.0L, 1), left = series(v, 1.0L, 1);
      EXPECT_LT(error(so3::right_jacobian(v), right), 5e-15) << "angle " << angle;
      EXPECT_LT(error(so3::left_jacobian(v), left), 5e-15) << "angle " << angle;
      EXPECT_LT(error(so3::right_jacobian_inverse(v), right.inverse()), 1e-14) << "angle " << angle;
      EXPECT_LT(error(so3::left_jacobian_inverse(v), left.inverse()), 1e-14) << "angle " << angle;
    }
  }
}

TEST(So3, exponential_agrees_with_power_series_in_long_double) {
  for (const double angle : kTurns) {
    for (const Vector3& n : test::directions()) {
      EXPECT_LT(error(Rot3::Exp(n * angle).matrix(), series(n * angle, 1.0L, 0)), 2e-15)
          << "angle " << angle;
    }
  }
}

// Exp(v + dv) = Exp(v) Exp(J_r dv) = Exp(J_l dv) Exp(v), by central differences.
TEST(So3, jacobians_agree_with_numerical_differentiation) {
  constexpr double kStep = 1e-5;
  for (const double angle : {0.0, 1e-8, 0.01, 0.3, 1.0, 2.5}) {
    for (const Vector3& n : test::directions()) {
      const Vector3 v = n * angle;
      const Rot3 R = Rot3::Exp(v);
      Matrix3 right, left;
      for (int i = 0; i < 3; ++i) {
        const Vector3 dv = Vector3::Unit(i) * kStep;
        const Rot3 plus = Rot3::Exp(v + dv), minus = Rot3::Exp(v - dv);
        right.col(i) = ((R.inverse() * plus).Log() - (R.inverse() * minus).Log()) / (2.0 * kStep);
        left.col(i) = ((plus * R.inverse()).Log() - (minus * R.inverse()).Log()) / (2.0 * kStep);
      }
      EXPECT_LT((so3::right_jacobian(v) - right).norm(), 1e-9) << "angle " << angle;
      EXPECT_LT((so3::left_jacobian(v) - left).norm(), 1e-9) << "angle " << angle;
    }
  }
}

TEST(So3, jacobian_times_its_inverse_is_the_identity_to_pi_and_beyond) {
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-4, 0.3162, 0.3163, 1.0, 3.0, 3.1415926, 4.0}) {
    for (const Vector3& n : test::directions()) {
      const Vector3 v = n * angle;
      const Matrix3 right = so3::right_jacobian(v) * so3::right_jacobian_inverse(v);
      const Matrix3 left = so3::left_jacobian_inverse(v) * so3::left_jacobian(v);
      EXPECT_LT((right - Matrix3::Identity()).norm(), 1e-14) << "angle " << angle;
      EXPECT_LT((left - Matrix3::Identity()).norm(), 1e-14) << "angle " << angle;
    }
  }
}

// Value and derivative of a coefficient on both sides of the change from series to closed form:
// their true difference is of the order of the gap, 1e-15. The closed forms are differences of
// numbers near 1 divided by theta^2 and have lost two digits there, four in the derivative.
template <class Ratio>
void expect_continuous(const char* name, const Ratio& ratio) {
  using D = Dual<1>;
  const D below = ratio(D::variable(so3::kSeriesBelow * (1.0 - 1e-15), 0));
  const D above = ratio(D::variable(so3::kSeriesBelow * (1.0 + 1e-15), 0));
  EXPECT_NEAR(below.v, above.v, 5e-14 * std::abs(above.v)) << name;
  EXPECT_NEAR(below.d[0], above.d[0], 1e-10 * std::abs(above.d[0])) << name;
}

TEST(So3, series_and_closed_forms_meet) {
  expect_continuous("cosine_ratio", [](const auto& t2) { return so3::cosine_ratio(t2); });
  expect_continuous("sine_ratio", [](const auto& t2) { return so3::sine_ratio(t2); });
  expect_continuous("cotangent_ratio", [](const auto& t2) { return so3::cotangent_ratio(t2); });
}

// By automatic differentiation at v = 0, where J_r = I - [v]/2 + ..., J_r^-1 = I + [v]/2 + ...
TEST(So3, jacobians_have_the_right_derivatives_at_exactly_zero) {
  using D = Dual<3>;
  Vec3<D> v;
  for (int i = 0; i < 3; ++i) v[i] = D::variable(0.0, i);
  const Mat3<D> right = so3::right_jacobian(v), inverse = so3::right_jacobian_inverse(v);
  for (int k = 0; k < 3; ++k) {
    const Matrix3 half = 0.5 * so3::hat<double>(Vector3::Unit(k));
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        EXPECT_EQ(right(i, j).v, i == j ? 1.0 : 0.0);
        EXPECT_EQ(inverse(i, j).v, i == j ? 1.0 : 0.0);
        EXPECT_EQ(right(i, j).d[k], -half(i, j));
        EXPECT_EQ(inverse(i, j).d[k], half(i, j));
      }
    }
  }
}

TEST(So3, hat_is_the_cross_product) {
  const Vector3 a(0.3, -1.2, 2.0), b(1.5, 0.4, -0.7);
  EXPECT_LT((so3::hat(a) * b - Eigen::Vector3d(a).cross(b)).norm(), 1e-15);
}

}  // namespace
}  // namespace magimu
