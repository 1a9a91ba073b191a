// SPDX-License-Identifier: BSD-3-Clause
#include "factors/harmonic_field.h"

#include <gtest/gtest.h>

#include "factors/field_basis.h"
#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using test::RandomValue;

SampleState state_of(RandomValue& random) {
  SampleState s;
  s.recording = 1;
  s.nRb = random.rotation();
  s.D = 45.0 * Matrix3::Identity() + random.matrix3(3.0);
  s.strength_uT = std::cbrt(s.D.determinant());
  s.position = random.vector3(0.3);
  return s;
}

std::vector<HarmonicField> two_fields(int order, RandomValue& random) {
  const int n = FieldBasis::size_of(order) - 3;
  std::vector<HarmonicField> out;
  for (int r = 0; r < 2; ++r) {
    VectorXd size(n);
    for (int i = 0; i < n; ++i) size[i] = 0.2 + std::abs(random.number());
    out.push_back({random.vector3(0.1), 0.2 + 0.1 * r, size});
  }
  return out;
}

class HarmonicFieldOf : public testing::TestWithParam<int> {};

TEST_P(HarmonicFieldOf, order_is_seen_through_the_distortion_and_changes_with_the_position) {
  const int order = GetParam(), n = FieldBasis::size_of(order) - 3;
  RandomValue random(unsigned(10 + order));
  const std::vector<HarmonicField> fields = two_fields(order, random);
  const auto effect = make_harmonic_field(order, fields);
  ASSERT_EQ(effect->size(), 2 * n);
  EXPECT_EQ(effect->prior_sigma(60.0).tail(n), fields[1].size_uT);
  for (int trial = 0; trial < 20; ++trial) {
    const SampleState s = state_of(random);
    VectorXd c(2 * n);
    for (int i = 0; i < 2 * n; ++i) c[i] = random.number();
    const Vector3 field = field_uT(fields[1], order, c.tail(n), s.position);
    const Vector3 seen = s.D * s.nRb.unrotate(field) / s.strength_uT;
    EXPECT_LT((effect->term(s, c) - seen).norm(), 1e-12 * (1.0 + seen.norm()));
    // Of the other recording nothing shows.
    VectorXd other = c;
    other.tail(n).setZero();
    EXPECT_EQ(effect->term(s, other).norm(), 0.0);
    constexpr double kStep = 1e-5;
    Matrix3 numerical;
    for (int i = 0; i < 3; ++i) {
      SampleState before = s, after = s;
      before.position[i] -= kStep;
      after.position[i] += kStep;
      numerical.col(i) = (effect->term(after, c) - effect->term(before, c)) / (2.0 * kStep);
    }
    EXPECT_LT((effect->by_position(s, c) - numerical).norm(), 1e-6 * (1.0 + numerical.norm()));
  }
}
INSTANTIATE_TEST_SUITE_P(Orders, HarmonicFieldOf, testing::Values(1, 2, 3));

TEST(HarmonicField, has_neither_curl_nor_divergence) {
  RandomValue random(3);
  const HarmonicField field = two_fields(3, random).front();
  VectorXd c(field.size_uT.size());
  for (Eigen::Index i = 0; i < c.size(); ++i) c[i] = random.number();
  const Vector3 at = random.vector3(0.2);
  constexpr double kStep = 1e-5;
  Matrix3 J;
  for (int i = 0; i < 3; ++i) {
    J.col(i) = (field_uT(field, 3, c, at + kStep * Vector3::Unit(i)) -
                field_uT(field, 3, c, at - kStep * Vector3::Unit(i))) /
               (2.0 * kStep);
  }
  EXPECT_LT(std::abs(J.trace()), 1e-6 * J.norm());
  EXPECT_LT((J - J.transpose()).norm(), 1e-6 * J.norm());
}

}  // namespace
}  // namespace magimu
