// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/rounding.h"

#include <gmock/gmock.h>

#include <cmath>

#include "recording/checks/quality.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kStep = 0.01, kRate = 100.0;

// A sensor that turns to and fro and rests in between, its noise in steps, rounded to `step`.
VectorSeries turning(double noise_steps, double step, std::uint64_t seed = 1) {
  RandomStream random(seed, RandomPurpose::kMotion);
  VectorSeries s;
  for (int k = 0; k < 3000; ++k) {
    const double t = k / kRate, size = std::pow(std::sin(0.3 * t), 4);
    Vector3 v(std::sin(1.7 * t), std::cos(1.1 * t), std::sin(0.9 * t + 1.0));
    v = size * v + Vector3(0.003, -0.004, 0.001) + noise_steps * kStep * random.normal3();
    if (step > 0.0) v = step * (v / step).array().round().matrix();
    s.push_back(t, v);
  }
  return s;
}

TEST(CoarseSteps, are_seen_where_noise_is_less_than_a_third_of_a_step) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const double noise : {0.01, 0.1, 0.2}) {
      const std::optional<Vector3> steps = coarse_steps(turning(noise, kStep, seed));
      ASSERT_TRUE(steps) << noise;
      EXPECT_NEAR(steps->minCoeff(), kStep, 1e-9);
      EXPECT_NEAR(steps->maxCoeff(), kStep, 1e-9);
    }
    for (const double noise : {0.5, 1.0, 10.0}) {
      EXPECT_FALSE(coarse_steps(turning(noise, kStep, seed))) << noise;
    }
  }
}

TEST(CoarseSteps, need_multiples_of_a_step) {
  EXPECT_FALSE(coarse_steps(turning(0.0, 0.0)));
  EXPECT_FALSE(coarse_steps(turning(0.1, 0.0)));
  VectorSeries turned = turning(0.1, kStep);
  const Matrix3 R = Rot3::Exp(Vector3(0.3, -0.2, 0.5)).matrix();
  for (Vector3& v : turned.v) v = R * v;
  EXPECT_FALSE(coarse_steps(turned)) << "corrected elsewhere";
  EXPECT_FALSE(coarse_steps({}));
}

TEST(CoarseSteps, are_no_sensor_that_is_read_more_often_than_it_measures) {
  VectorSeries held = turning(1.0, 0.1 * kStep);
  for (std::size_t k = 0; k < held.size(); ++k) held.v[k] = held.v[k - k % 4];
  EXPECT_FALSE(coarse_steps(held));
}

// Such as `Serial.print(rate)` writes, with two decimals.
TEST(CoarseSteps, of_a_gyroscope_are_told_instead_of_a_slower_clock) {
  Recording r;
  r.name = "two_decimals.csv";
  r.gyr = turning(0.1, kStep);
  Rot3 nRb;
  RandomStream random(2, RandomPurpose::kMotion);
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    const Vector3 up = nRb.inverse() * Vector3::UnitZ();
    r.acc.push_back(r.gyr.t[k], 9.8 * up + 0.02 * random.normal3());
    nRb = nRb * Rot3::Exp(Vector3(r.gyr.v[k] / kRate));
  }
  std::vector<std::string> kinds;
  for (const Issue& issue : check_recording(r)) {
    if (issue.sensor != "gyr") continue;
    kinds.push_back(issue.kind);
    EXPECT_THAT(issue.text(), testing::HasSubstr("0.01 rad/s"));
    EXPECT_THAT(issue.text(), testing::HasSubstr("write more digits"));
  }
  EXPECT_THAT(kinds, testing::ElementsAre("rounding"));
}

}  // namespace
}  // namespace magimu
