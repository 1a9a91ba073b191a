// SPDX-License-Identifier: BSD-3-Clause
// A matrix that is a turn is told as one.
#include "factors/effects/turn_words.h"

#include <gmock/gmock.h>

#include "factors/effects/catalogue.h"
#include "factors/effects/change.h"
#include "factors/sensor_model.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Readings of a sensor that is turned by so much against its frame.
Matrix3 readings_of_turned(const Vector3& by_deg) {
  return Rot3::Exp(Vector3(-kDegree * by_deg)).matrix();
}

VectorXd in_rows(const Matrix3& M) {
  VectorXd out(9);
  for (int i = 0; i < 9; ++i) out[i] = M(i / 3, i % 3);
  return out;
}

TEST(TurnWords, tell_angle_and_axis) {
  const auto x = turn_and_rest(readings_of_turned({25.0, 0.0, 0.0}), Matrix3::Constant(1e-3));
  ASSERT_TRUE(x);
  EXPECT_TRUE(is_mostly_a_turn(*x));
  EXPECT_EQ(turned_words(*x), "turned by 25.0 +- 0.041 deg about x");
  const auto z = turn_and_rest(readings_of_turned({0.0, 0.0, -3.0}));
  EXPECT_EQ(turned_words(*z), "turned by -3.0 deg about z");
  const auto askew = turn_and_rest(45.0 * readings_of_turned({10.0, -10.0, 10.0}));
  EXPECT_EQ(turned_words(*askew), "turned by 17.3 deg about (0.58, -0.58, 0.58)");
  EXPECT_NEAR(askew->scale, 45.0, 1e-9);
  EXPECT_NEAR(askew->rest, 0.0, 1e-9);
}

TEST(TurnWords, do_not_call_gains_or_chance_a_turn) {
  const Matrix3 gains = Vector3(1.02, 1.0, 0.99).asDiagonal();
  EXPECT_FALSE(is_mostly_a_turn(*turn_and_rest(gains, Matrix3::Constant(1e-3))));
  EXPECT_FALSE(is_mostly_a_turn(
      *turn_and_rest(readings_of_turned({0.1, 0.0, 0.0}), Matrix3::Constant(5e-3))));
  EXPECT_FALSE(turn_and_rest(-Matrix3::Identity()));
}

TEST(TurnWords, are_those_of_a_gyroscope_that_is_mounted_askew) {
  const auto effect = find_effect("gyro_scale_misalignment");
  const Matrix3 turned = readings_of_turned({0.0, 25.0, 0.0});
  const VectorXd sigma = VectorXd::Constant(9, 1e-4);
  EXPECT_THAT(effect->sentence(in_rows(turned - Matrix3::Identity()), sigma),
              AllOf(HasSubstr("The gyroscope is turned by 25.0 "), HasSubstr("deg about y"),
                    Not(HasSubstr("S[0]"))));
  EXPECT_THAT(effect->sentence(in_rows(Vector3(0.02, 0.0, 0.0).asDiagonal()), sigma),
              HasSubstr("clearest S[0][0]"));
  const auto change = make_change("mag_change", ChangeForm::kMatrix, {{0, 20.0}, kToTheEnd});
  EXPECT_THAT(change->sentence(in_rows(turned - Matrix3::Identity()), sigma),
              AllOf(HasSubstr("sat otherwise on its board"), HasSubstr("turned by 25.0 ")));
}

}  // namespace
}  // namespace magimu
