// SPDX-License-Identifier: BSD-3-Clause
// What the model lacks and residuals do not show: the verdict must know of it.
#include "calibration/scan/missing_effects.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include "calibration/calibrate.h"
#include "tests/calibration/truth_distance.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

oracle::Simulation hidden(const std::vector<oracle::Effect>& effects,
                          oracle::MotionKind motion = oracle::MotionKind::kRotation) {
  oracle::Options o;
  o.seed = 5;
  o.rate_hz = 50.0;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.noise = oracle::kRealisticDensities;
  o.motion.kind = motion;
  o.motion.duration_s = 90.0;
  o.motion.fastest_rad_s = 2.0;
  o.effects = effects;
  return oracle::simulate(o);
}

double distance(const VectorXd& error, const MatrixXd& covariance) {
  return error.dot(covariance.topLeftCorner(19, 19).ldlt().solve(error));
}

const Check& model_check(const Calibration& c) {
  const auto it = std::find_if(c.checks.begin(), c.checks.end(),
                               [](const Check& check) { return check.name == "model"; });
  EXPECT_NE(it, c.checks.end());
  return *it;
}

// A magnetometer that averages shows less of a field that turns: D would be too small by it.
TEST(MissingEffects, a_filter_in_the_magnetometer_is_seen_and_the_sigmas_hold) {
  for (const double width : {0.05, 0.1, 0.2}) {
    const oracle::Simulation s =
        hidden({oracle::make_effect("mag_bandwidth", {width * width / 12.0}),
                oracle::make_effect("mag_time_offset", {0.5 * width})},
               oracle::MotionKind::kHandHeld);
    const Calibration c = calibrate(s.recording);
    const VectorXd error = test::error_of(c, s.truth.device);
    EXPECT_LT(distance(error, c.covariance), test::kOutside) << width;
  }
}

TEST(MissingEffects, nothing_hidden_nothing_seen_and_the_sigmas_stay) {
  const oracle::Simulation s = hidden({});
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(model_check(c).status, CheckStatus::kOk) << model_check(c).sentence;
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
  for (int i = 0; i < 19; ++i) {
    EXPECT_LT(std::sqrt(c.covariance(i, i) / c.covariance_model(i, i)), 2.0) << c.order[i];
  }
}

TEST(MissingEffects, a_gyroscope_with_scale_errors_is_covered_by_the_reported_sigmas) {
  const oracle::Simulation s = hidden({oracle::make_effect(
      "gyro_scale_misalignment", {.006, .002, -.003, .001, -.008, .002, .004, -.002, .005})});
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;  // which has no such matrix
  options.gyr_matrix = false;
  const Calibration c = calibrate(s.recording, options);
  const VectorXd e = test::error_of(c, s.truth.device);
  EXPECT_GT(distance(e, c.covariance_model), test::kOutside) << "the effect must do harm";
  EXPECT_LT(distance(e, c.covariance), test::kOutside);
  EXPECT_NE(model_check(c).status, CheckStatus::kOk);
}

// The matrix of the model has all nine entries: a gyroscope that is turned against the
// accelerometer is in it as well as one with scale errors.
TEST(MissingEffects, a_gyroscope_that_is_turned_is_in_the_model) {
  const std::vector<double> S = {.008, .012, -.009, -.012, -.006, .01, .009, -.01, .005};
  const oracle::Simulation s =
      hidden({oracle::make_effect("gyro_scale_misalignment", S)}, oracle::MotionKind::kHandHeld);
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  const VectorXd e = test::error_of(c, s.truth.device);
  EXPECT_LT(distance(e, c.covariance_model), test::kOutside);
  EXPECT_LT(distance(e, c.covariance), test::kOutside);
  EXPECT_THAT(model_check(c).sentence,
              testing::Not(testing::HasSubstr("the gyroscope's axes have scale errors")));
  ASSERT_FALSE(c.effects.empty());
  EXPECT_EQ(c.effects[0].name, "gyro_scale_misalignment");
  ASSERT_EQ(c.effects[0].parameters.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) {
    const ActiveEffect::Parameter& p = c.effects[0].parameters[i];
    EXPECT_LT(p.sigma, 5e-3) << p.name;
    EXPECT_NEAR(p.value, S[i], 4.5 * p.sigma) << p.name;
  }
}

TEST(MissingEffects, a_gyroscope_that_rectifies_vibration_is_told_without_a_name) {
  const oracle::Simulation s =
      hidden({oracle::make_effect("gyro_rectification", {2e-4, -1e-4, 3e-4})});
  const Calibration c = calibrate(s.recording);
  const VectorXd e = test::error_of(c, s.truth.device);
  EXPECT_GT(distance(e, c.covariance_model), test::kOutside) << "the effect must do harm";
  EXPECT_TRUE(c.trust.verdict != Verdict::kYes || distance(e, c.covariance) < test::kOutside)
      << distance(e, c.covariance);
  EXPECT_THAT(model_check(c).sentence, testing::HasSubstr("missing in the model"));
}

TEST(MissingEffects, what_is_added_to_the_covariance_reaches_every_reported_sigma) {
  const oracle::Simulation s = hidden({});
  Calibration c = calibrate(s.recording);
  const Calibration before = c;
  MissingEffect f;
  f.name = "gyro_bias_drift";
  f.cause = "the gyroscope's bias wanders";
  f.shift = VectorXd::Zero(Eigen::Index(c.order.size()));
  f.covariance = MatrixXd::Zero(f.shift.size(), f.shift.size());
  f.shift[4] = 3.0 * before.sigma("gyroscope.bias[1]");
  f.shift[18] = 4.0 * before.sigma("field.dip_deg");
  add_missing_effects(c, {f});
  // And a little everywhere, for what one step leaves.
  const auto grown = [&](const char* name) { return c.sigma(name) / before.sigma(name); };
  EXPECT_NEAR(grown("gyroscope.bias[1]"), std::sqrt(10.0), 0.02);
  EXPECT_NEAR(c.fields[0].dip_sigma_rad / before.fields[0].dip_sigma_rad, std::sqrt(17.0), 0.02);
  EXPECT_GT(grown("gyroscope.bias[0]"), 1.0);
  EXPECT_LT(grown("gyroscope.bias[0]"), 1.02);
  EXPECT_THAT(c.checks.back().sentence, testing::HasSubstr("the gyroscope's bias wanders"));
}

}  // namespace
}  // namespace magimu
