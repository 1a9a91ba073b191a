// SPDX-License-Identifier: BSD-3-Clause
#include "graph/rot3.h"

#include <Eigen/LU>

#include "graph/dual.h"
#include "tests/graph/directions.h"

namespace magimu {
namespace {

using test::directions;
using test::kPi;

const std::vector<double> kAngles = {1e-300, 1e-100,     1e-12,      1e-8,       1e-4, 1.9e-3,
                                     2.1e-3, 0.0316,     0.0317,     0.1,        1.0,  2.0,
                                     3.0,    kPi - 1e-3, kPi - 1e-8, kPi - 1e-12};

double largest_difference(const Rot3& a, const Rot3& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(Rot3, logarithm_inverts_the_exponential_in_every_direction) {
  for (const double angle : kAngles) {
    for (const Vector3& n : directions()) {
      const Vector3 v = n * angle;
      EXPECT_LE((Rot3::Exp(v).Log() - v).cwiseAbs().maxCoeff(),
                1e-15 * std::min(1.0, angle) + (angle > 1.0 ? 1e-15 : 0.0))
          << "angle " << angle << " about " << n.transpose();
    }
  }
}

TEST(Rot3, exponential_inverts_the_logarithm_at_pi_exactly) {
  for (const Vector3& n : directions()) {
    const Vector3 v = n * kPi;
    const Rot3 R = Rot3::Exp(v);
    const Vector3 back = R.Log();
    EXPECT_LT(largest_difference(Rot3::Exp(back), R), 1e-15) << n.transpose();
    EXPECT_LE(back.norm(), kPi * (1.0 + 1e-15));
    // v and -v are the same rotation to within rounding.
    EXPECT_LT(std::min((back - v).norm(), (back + v).norm()), 2e-15);
  }
}

TEST(Rot3, a_half_turn_given_exactly_has_an_angle_of_pi) {
  for (int i = 0; i < 3; ++i) {
    for (const double w : {0.0, -0.0}) {
      Vector4 q = Vector4::Zero();
      q[0] = w;
      q[i + 1] = 1.0;
      EXPECT_EQ(Rot3::from_unit_quaternion(q).Log(), Vector3(Vector3::Unit(i) * kPi));
    }
  }
}

TEST(Rot3, the_identity_has_logarithm_zero_whatever_the_quaternions_sign) {
  EXPECT_EQ(Rot3().Log(), Vector3(Vector3::Zero()));
  EXPECT_EQ(Rot3::from_unit_quaternion(Vector4(-1, 0, 0, 0)).Log(), Vector3(Vector3::Zero()));
  EXPECT_EQ(Rot3::Exp(Vector3::Zero()).quaternion(), Vector4(1, 0, 0, 0));
}

TEST(Rot3, quaternions_of_either_sign_have_one_logarithm) {
  for (const double angle : kAngles) {
    for (const Vector3& n : directions()) {
      const Rot3 R = Rot3::Exp(n * angle);
      const Rot3 same = Rot3::from_unit_quaternion(-R.quaternion());
      EXPECT_EQ(R.Log(), same.Log()) << "angle " << angle;
    }
  }
}

// d Log(Exp(v)) / dv = I, at zero and on both sides of every change of formula.
TEST(Rot3, automatic_derivatives_are_right_at_every_angle) {
  std::vector<double> angles = kAngles;
  angles.push_back(0.0);
  for (const double angle : angles) {
    for (const Vector3& n : directions()) {
      Vec3<Dual<3>> v;
      for (int i = 0; i < 3; ++i) v[i] = Dual<3>::variable(n[i] * angle, i);
      const Vec3<Dual<3>> back = Rot3T<Dual<3>>::Exp(v).Log();
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          EXPECT_NEAR(back[i].d[j], i == j ? 1.0 : 0.0, 2e-14) << "angle " << angle;
        }
      }
    }
  }
}

// Numbers that the two formulas for one value give on both sides of their limit must agree.
TEST(Rot3, series_and_closed_forms_meet) {
  for (const Vector3& n : directions()) {
    const double exp_limit = std::sqrt(1e-3), log_limit = 2.0 * std::asin(1e-3);
    for (const double limit : {exp_limit, log_limit}) {
      const Vector3 below = n * (limit * (1.0 - 1e-14)), above = n * (limit * (1.0 + 1e-14));
      EXPECT_LT((Rot3::Exp(above).quaternion() - Rot3::Exp(below).quaternion()).norm(),
                3e-14 * limit + 3e-16);
      EXPECT_LT((Rot3::Exp(above).Log() - Rot3::Exp(below).Log()).norm(), 3e-14 * limit);
    }
  }
}

TEST(Rot3, a_rotation_vector_longer_than_pi_comes_back_as_the_shorter_way_round) {
  for (const Vector3& n : directions()) {
    EXPECT_LT((Rot3::Exp(n * 4.0).Log() - n * (4.0 - 2.0 * kPi)).norm(), 3e-15);
  }
}

TEST(Rot3, a_matrix_of_any_trace_comes_back) {
  std::vector<Rot3> rotations{Rot3()};
  for (const double angle : {1e-9, 0.5, 2.0, 2.2, 3.0, kPi - 1e-8, kPi}) {
    for (const Vector3& n : directions()) rotations.push_back(Rot3::Exp(n * angle));
  }
  test::RandomValue random(3);
  for (int i = 0; i < 200; ++i) rotations.push_back(random.rotation());
  int negative_traces = 0;
  for (const Rot3& R : rotations) {
    const Matrix3 m = R.matrix();
    negative_traces += m.trace() < 0.0 ? 1 : 0;
    EXPECT_LT((m * m.transpose() - Matrix3::Identity()).norm(), 3e-15);
    EXPECT_GT(m.determinant(), 0.0);
    EXPECT_LT(largest_difference(Rot3::from_matrix(m), R), 3e-15) << R.Log().transpose();
    EXPECT_NEAR(Rot3::from_matrix(m).quaternion().norm(), 1.0, 1e-15);
  }
  EXPECT_GT(negative_traces, 100);
}

TEST(Rot3, product_inverse_and_action_are_those_of_matrices) {
  test::RandomValue random(4);
  for (int i = 0; i < 100; ++i) {
    const Rot3 a = random.rotation(), b = random.rotation();
    const Vector3 v = random.vector3();
    EXPECT_LT(((a * b).matrix() - a.matrix() * b.matrix()).norm(), 3e-15);
    EXPECT_LT((((a * b) * b.inverse()).matrix() - a.matrix()).norm(), 3e-15);
    EXPECT_LT((a * v - a.matrix() * v).norm(), 1e-14);
    EXPECT_LT((a.unrotate(v) - a.inverse() * v).norm(), 1e-14);
  }
}

TEST(Rot3, from_quaternion_normalizes) {
  const Rot3 R = Rot3::from_quaternion(Vector4(2.0, 0.0, 2.0, 0.0));
  EXPECT_LT((R.Log() - Vector3(0.0, kPi / 2.0, 0.0)).norm(), 1e-15);
}

TEST(Rot3, a_matrix_that_is_no_rotation_is_refused) {
  Matrix3 sheared;
  sheared << 1, 2, 3, 4, 5, 6, 7, 8, 10;
  EXPECT_THROW(Rot3::from_matrix(sheared), std::invalid_argument);
  EXPECT_THROW(Rot3::from_matrix(-Matrix3::Identity()), std::invalid_argument);
  EXPECT_THROW(Rot3::from_matrix(Matrix3::Constant(std::nan(""))), std::invalid_argument);
  const Rot3 R = Rot3::Exp(Vector3(0.3, -0.2, 0.7));
  const Matrix3 rounded = (R.matrix() * 1000.0).array().round() / 1000.0;
  EXPECT_LT(largest_difference(Rot3::from_matrix(rounded), R), 1e-3);
}

}  // namespace
}  // namespace magimu
