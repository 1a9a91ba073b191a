// SPDX-License-Identifier: BSD-3-Clause
// Between a gyroscope's samples, which are means over intervals, against a swing about one axis
// whose angle is known in closed form.
#include "calibration/motion/integrated_rotation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

constexpr double kRateHz = 50.0, kSwing = 1.2, kOmega = 6.0;  // rad, rad/s

double angle(double t) { return kSwing * std::sin(kOmega * t); }

VectorSeries swinging(double rest_s = 0.0) {
  VectorSeries gyr;
  for (int k = 0; k < 200; ++k) {
    const double t = k / kRateHz, next = (k + 1) / kRateHz;
    if (t > 1.0 && t < 1.0 + rest_s) continue;
    gyr.push_back(t, Vector3(0.0, 0.0, (angle(next) - angle(t)) * kRateHz));
  }
  return gyr;
}

TEST(IntegratedRotation, follows_a_swing_within_a_sample_s_interval) {
  const VectorSeries gyr = swinging();
  const IntegratedRotation rotation(gyr, Vector3::Zero());
  // A rate that is held is wrong by an eighth of the acceleration times the squared interval.
  const double held = kSwing * kOmega * kOmega / (8.0 * kRateHz * kRateHz);
  double worst = 0.0, worst_rate = 0.0;
  for (double t = 0.1; t < 3.8; t += 0.0007) {
    const Vector3 turned = rotation.at(t).Log();
    worst = std::max(worst, std::abs(turned.z() - angle(t)));
    worst_rate = std::max(worst_rate,
                          std::abs(rotation.rate(t).z() - kSwing * kOmega * std::cos(kOmega * t)));
  }
  EXPECT_LT(worst, 0.1 * held);
  EXPECT_LT(worst_rate, 0.1 * kSwing * kOmega * kOmega / (2.0 * kRateHz));
}

// Of a rate whose axis moves: all parts of a sample's interval together lead as far as the sample.
TEST(IntegratedRotation, is_the_same_in_one_piece_and_in_many) {
  VectorSeries gyr, acc;
  for (int k = 0; k < 60; ++k) {
    const double t = k / kRateHz;
    gyr.push_back(t, Vector3(4.0 * std::cos(9.0 * t), 4.0 * std::sin(9.0 * t), 1.0));
    for (const double later : {0.0, 0.003, 0.011}) acc.push_back(t + later, Vector3::UnitZ());
  }
  const IntegratedRotation rotation(gyr, Vector3::Zero());
  const Rot3 turned = rotation.preintegrate(0.2, 0.8, acc, Vector3::Zero(), false).delta_R();
  const double coning = 0.6 * 4.0 * 4.0 * 9.0 / (12.0 * kRateHz * kRateHz);
  EXPECT_LT((rotation.between(0.2, 0.8).inverse() * turned).Log().norm(), 0.03 * coning);
}

// Nodes at a magnetometer's own times: what leads from one to the next agrees with what leads to
// the samples beside them.
TEST(IntegratedRotation, preintegrates_to_where_it_says_that_the_sensor_is) {
  const VectorSeries gyr = swinging();
  const IntegratedRotation rotation(gyr, Vector3::Zero());
  VectorSeries acc;
  for (int k = 0; k < 200; ++k) acc.push_back(k / kRateHz, Vector3(0.0, 0.0, 9.8));
  for (double a = 0.113; a < 3.6; a += 0.0171) {
    const double b = a + 0.0873;
    const Vector3 expected = rotation.between(a, b).Log();
    const Rot3 turned = rotation.preintegrate(a, b).delta();
    const Rot3 in_hand = rotation.preintegrate(a, b, acc, Vector3::Zero(), false).delta_R();
    EXPECT_LT((turned.Log() - expected).norm(), 1e-12) << a;
    EXPECT_LT((in_hand.Log() - expected).norm(), 1e-12) << a;
  }
}

TEST(IntegratedRotation, does_not_bend_across_a_gap) {
  const VectorSeries whole = swinging(), gap = swinging(0.5);
  const IntegratedRotation rotation(gap, Vector3::Zero());
  // The last sample before the gap is held through it.
  const double begin = 1.0, last = whole.v[50].z();
  EXPECT_NEAR(rotation.between(begin, begin + 0.01).Log().z(), 0.01 * last, 1e-12);
  EXPECT_NEAR(rotation.rate(begin + 0.01).z(), last, 1e-12);
}

}  // namespace
}  // namespace magimu
