// SPDX-License-Identifier: BSD-3-Clause
// A calibration that makes orientation worse than the readings are as they come says so.
#include "calibration/trust/better_than_none.h"

#include <Eigen/LU>
#include <algorithm>

#include "calibration/fit/parameter_prior.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

const Check* gain_of(const Calibration& c) {
  const auto at = std::ranges::find(c.checks, "gain", &Check::name);
  return at == c.checks.end() ? nullptr : &*at;
}

// As a magnetometer without a bias whose matrix is so much of what it was away from a scale.
Simulation with_less_distortion(double share) {
  Simulation s = test::simulated_hand(50.0, 31, 90.0);
  const MagnetometerParameters& mag = s.truth.parameters.mag.front();
  const double strength = s.truth.strength_uT;
  const Matrix3 mounting = nearest_mounting(mag.distortion);
  const Matrix3 wanted = strength * mounting + share * (mag.distortion - strength * mounting);
  for (Vector3& v : s.recording.mag.front().v) {
    v = wanted * (mag.distortion.inverse() * (v - mag.bias)) + share * mag.bias;
  }
  return s;
}

TEST(BetterThanNone, what_is_far_off_need_not_be_asked) {
  Simulation s = test::simulated_hand(50.0, 31, 90.0);
  for (Vector3& v : s.recording.mag.front().v) v += Vector3(15.0, 0.0, 0.0);
  const Calibration c = calibrate(s.recording, test::same_model(s, 2));
  ASSERT_TRUE(gain_of(c));
  EXPECT_NE(gain_of(c)->sentence.find("would be off by up to"), std::string::npos);
}

TEST(BetterThanNone, a_small_distortion_is_worth_its_calibration) {
  const Simulation s = with_less_distortion(0.5);
  const Calibration c = calibrate(s.recording, test::same_model(s, 2));
  ASSERT_TRUE(gain_of(c));
  EXPECT_EQ(gain_of(c)->status, CheckStatus::kOk);
  EXPECT_GT(gain_of(c)->value, 1.5) << gain_of(c)->sentence;
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
}

TEST(BetterThanNone, a_sensor_that_needs_none_loses_nothing) {
  const Simulation s = with_less_distortion(0.0);
  const Calibration c = calibrate(s.recording, test::same_model(s, 2));
  ASSERT_TRUE(gain_of(c));
  EXPECT_EQ(gain_of(c)->status, CheckStatus::kOk);
  EXPECT_NEAR(gain_of(c)->value, 1.0, 0.05);
  EXPECT_NE(gain_of(c)->sentence.find("no gain is shown"), std::string::npos)
      << gain_of(c)->sentence;
}

TEST(BetterThanNone, predictions_that_are_worse_are_told) {
  BlockErrors good, bad;
  for (int i = 0; i < 20; ++i) {
    good.held_out.push_back(1.0 + 0.1 * (i % 3));
    bad.held_out.push_back(2.0 + 0.1 * (i % 5));
  }
  good.values = bad.values = 2000.0;
  EXPECT_EQ(check_gain(good, bad, 50.0).status, CheckStatus::kBad);
  EXPECT_EQ(check_gain(good, bad, 50.0).sentence.substr(0, 18), "Keep what you have");
  EXPECT_EQ(check_gain(bad, good, 50.0).status, CheckStatus::kOk);
}

}  // namespace
}  // namespace magimu
