// SPDX-License-Identifier: BSD-3-Clause
// The hand moves the sensor: errors as large as said, the motion recognised, effects that real
// parts have found and taken into the model, and none that is not there. bench/statistics.cpp and
// bench/answers/verdicts.cpp have the same in full.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>

#include "calibration/fit/parameter_prior.h"
#include "calibration/motion/rests/rests.h"
#include "tests/calibration/cases.h"
#include "tests/calibration/tremor.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

TEST(HandHeld, errors_are_at_the_cramer_rao_bound_and_as_large_as_the_covariance_says) {
  constexpr int kDataSets = 10;
  ErrorStatistics statistics;
  for (int seed = 1; seed <= kDataSets; ++seed) {
    SimulationOptions simulated;
    simulated.motion = SimulatedMotion::kHandHeld;
    simulated.rate_hz = 50.0;
    simulated.seed = std::uint64_t(seed);
    const Simulation s = simulate(simulated);
    CalibrationOptions options = test::same_model(s, 4);
    options.noise = s.truth.noise;
    options.motion = MotionModel::kHandHeld;
    options.gyr_matrix = false;
    const Calibration c = calibrate(s.recording, options);
    EXPECT_TRUE(c.fit.converged()) << "seed " << seed << ": " << c.fit.message;
    statistics.add(c, s.truth.parameters);
  }
  for (const GroupStatistics& g : statistics.groups(kBand999)) {
    EXPECT_TRUE(g.inside()) << g.name << ": RMSE " << g.rmse << ", bound " << g.bound;
  }
  const NeesStatistics n = statistics.nees(kBand999);
  EXPECT_TRUE(n.inside()) << n.mean << " not in [" << n.band.low << ", " << n.band.high << "]";
  for (const double ratio : statistics.sigma_ratio()) {  // honest, not inflated
    EXPECT_GT(ratio, 0.7);
    EXPECT_LT(ratio, 1.4);
  }
}

// Fifty samples a second whose reader was told of sixty: every turn comes out a sixth too short.
TEST(HandHeld, a_rate_that_no_gyroscope_has_wrong_is_told) {
  SimulationOptions simulated;
  simulated.motion = SimulatedMotion::kHandHeld;
  simulated.rate_hz = 50.0;
  simulated.duration_s = 60.0;
  simulated.seed = 9401;
  simulated.gravity = CalibrationOptions().gravity;
  Simulation s = simulate(simulated);
  EXPECT_EQ(calibrate(s.recording).trust.verdict, Verdict::kYes);
  for (VectorSeries* series : {&s.recording.acc, &s.recording.gyr, &s.recording.mag.front()}) {
    for (double& t : series->t) t *= 50.0 / 60.0;
  }
  const Calibration c = calibrate(s.recording);
  EXPECT_NE(c.trust.verdict, Verdict::kYes);
  EXPECT_THAT(c.trust.reasons, testing::Contains(testing::HasSubstr("0.83")));
  EXPECT_THAT(c.trust.reasons, testing::Contains(testing::HasSubstr("--rate")));
}

oracle::Options realistic(oracle::MotionKind kind, std::uint64_t seed) {
  oracle::Options options;
  options.seed = seed;
  options.rate_hz = 50.0;
  options.device_kind = oracle::DeviceKind::kBoard;
  options.noise = oracle::kRealisticDensities;
  options.motion.kind = kind;
  options.motion.duration_s = 90.0;
  options.motion.band_hz[1] = 1.0;
  return options;
}

double distance(const Calibration& c, const oracle::Device& device) {
  SensorParameters truth;
  truth.acc_bias = device.acc_bias;
  truth.gyr_bias = device.gyr_bias;
  truth.dip_rad = device.dip_rad;
  truth.mag = {{device.distortion, device.mag_bias}};
  const VectorXd e =
      in_calibration_order(c).head(19) - in_calibration_order(truth, {truth.dip_rad});
  return nees(e, c.covariance.topLeftCorner(19, 19));
}

// Nothing told, noise of ordinary parts: the motion is recognised, the truth is where it is said to
// be, and nothing is found that is not there.
TEST(HandHeld, a_moved_sensor_is_recognised_and_calibrated_with_nothing_told) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const oracle::Simulation s = simulate(realistic(oracle::MotionKind::kHandHeld, seed));
    const Calibration c = calibrate(s.recording);
    EXPECT_EQ(c.motion, MotionModel::kHandHeld);
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
    EXPECT_LT(distance(c, s.truth.device), 60.0);  // 19 expected; 1 in 300,000 beyond
    EXPECT_TRUE(c.effects.empty()) << c.effects.front().name;
    // The trajectory follows the gyroscope so closely that its residuals cannot tell its noise.
    EXPECT_GT(c.noise.gyr, 0.7 * s.truth.noise.gyr);
    EXPECT_LT(c.noise.gyr, 2.0 * s.truth.noise.gyr);
  }
}

// On a stick, and in a hand that is itself moved: the position follows the attitude, and neither
// gravity nor the accelerometer's bias pays for it.
TEST(HandHeld, a_lever_arm_is_measured_and_no_bias_stands_in_for_it) {
  for (const auto kind : {oracle::MotionKind::kRotation, oracle::MotionKind::kHandHeld}) {
    double biases = 0.0, arms = 0.0;
    constexpr int kSeeds = 5;
    for (std::uint64_t seed = 11; seed < 11 + kSeeds; ++seed) {
      SCOPED_TRACE(seed);
      oracle::Options options = realistic(kind, seed);
      const Vector3 arm(-0.43, 0.22, 0.11);
      options.effects = {oracle::make_effect("lever_arm", {arm.x(), arm.y(), arm.z()})};
      const oracle::Simulation s = simulate(options);
      const Calibration c = calibrate(s.recording);
      ASSERT_EQ(c.motion, MotionModel::kHandHeld);
      EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
      const Vector3 bias = c.parameters.acc_bias - s.truth.device.acc_bias;
      biases += bias.dot(c.covariance.topLeftCorner<3, 3>().ldlt().solve(bias));
      ASSERT_EQ(c.lever_arms.size(), 1u);
      const Vector3 error = c.lever_arms.front().value - arm;
      EXPECT_LT(error.norm(), 0.1);
      arms += error.dot(c.lever_arms.front().covariance.ldlt().solve(error));
    }
    // Chi-square with 15 degrees of freedom: 1 in 10,000 beyond 43.
    EXPECT_LT(biases, 43.0);
    EXPECT_LT(arms, 43.0);
  }
}

// The readings of a sensor that a trembling hand turns. rests: whether it ever holds still.
Recording trembling(double rate_hz, std::uint64_t seed, double size_mm, bool rests = false) {
  oracle::Options options = realistic(oracle::MotionKind::kRotation, seed);
  options.rate_hz = rate_hz;
  if (!rests) options.motion.rest_s = options.motion.pause_s = 0.0;
  Recording r = simulate(options).recording;
  test::add_tremor(r, seed, size_mm);
  return r;
}

// No rest shows how large the accelerometer's noise is, and what remains beside gravity is as good
// as white: noise of 20 times that of the noisiest parts or a hand.
TEST(HandHeld, a_hand_that_never_rests_is_not_taken_for_noise_of_the_accelerometer) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const Calibration c = calibrate(trembling(25.0, seed, 5.0));
    EXPECT_EQ(c.motion, MotionModel::kHandHeld) << c.motion_reason;
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  }
}

// A hand that holds still trembles: what the accelerometer reads then is no noise of its own.
TEST(HandHeld, a_hand_that_holds_still_is_not_taken_for_a_rest) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const Recording r = trembling(50.0, seed, 0.2, true);
    ASSERT_FALSE(find_rests(r).empty());
    const Calibration c = calibrate(r);
    EXPECT_EQ(c.motion, MotionModel::kHandHeld) << c.motion_reason;
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  }
}

TEST(HandHeld, a_sensor_that_only_turns_and_never_rests_is_calibrated_by_the_rotation_model) {
  for (const double rate_hz : {25.0, 100.0}) {
    const Calibration c = calibrate(trembling(rate_hz, 4, 0.0));
    EXPECT_EQ(c.motion, MotionModel::kRotation) << c.motion_reason;
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  }
}

TEST(HandHeld, a_sensor_that_only_turns_is_calibrated_by_the_rotation_model) {
  const oracle::Simulation s = simulate(realistic(oracle::MotionKind::kRotation, 4));
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.motion, MotionModel::kRotation);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  EXPECT_LT(distance(c, s.truth.device), 60.0);
}

TEST(HandHeld, a_lag_and_scale_errors_of_the_gyroscope_are_found_and_measured) {
  oracle::Options options = realistic(oracle::MotionKind::kHandHeld, 5);
  // 1 % of scale, 0.4 deg of misalignment: S row by row.
  const std::vector<double> S = {0.010, 0, 0, 0.006, -0.008, 0, -0.004, 0.007, 0.005};
  options.effects = {oracle::make_effect("mag_time_offset", {0.012}),
                     oracle::make_effect("gyro_scale_misalignment", S)};
  const oracle::Simulation s = simulate(options);
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  ASSERT_EQ(c.effects.size(), 2u);
  EXPECT_EQ(c.effects[0].name, "mag_time_offset");
  EXPECT_NEAR(c.effects[0].parameters[0].value, 0.012, 4.0 * c.effects[0].parameters[0].sigma);
  EXPECT_LT(c.effects[0].parameters[0].sigma, 1e-3);
  EXPECT_EQ(c.effects[1].name, "gyro_scale_misalignment");
  for (const ActiveEffect::Parameter& p : c.effects[1].parameters) {
    const int row = p.name[p.name.size() - 5] - '0', column = p.name[p.name.size() - 2] - '0';
    EXPECT_NEAR(p.value, S[std::size_t(3 * row + column)], 4.5 * p.sigma) << p.name;
    EXPECT_LT(p.sigma, 2e-3);
  }
  EXPECT_LT(distance(c, s.truth.device), 60.0);
}

bool has_effect(const Calibration& c, const std::string& name) {
  return std::ranges::any_of(c.effects, [&](const ActiveEffect& e) { return e.name == name; });
}

// As data sheets of consumer parts give them: 2 % of scale, 0.6 deg, 0.05 deg/s per m/s^2.
TEST(HandHeld, errors_of_ordinary_parts_are_estimated_instead_of_bending_the_motion) {
  oracle::Options options = realistic(oracle::MotionKind::kHandHeld, 71);
  const std::vector<double> L = {0.011, 0.010, -0.012, 0.004, -0.006, -0.021};
  const std::vector<double> G = {8e-4, -3e-4, 2e-4, 5e-4, -9e-4, 1e-4, -2e-4, 4e-4, 7e-4};
  options.effects = {oracle::make_effect("acc_scale_misalignment", L),
                     oracle::make_effect("gyro_g_sensitivity", G)};
  const oracle::Simulation s = simulate(options);
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  for (const auto& [name, truth] : {std::pair(std::string("acc_scale_misalignment"), L),
                                    {std::string("gyro_g_sensitivity"), G}}) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(has_effect(c, name));
    for (const ActiveEffect& effect : c.effects) {
      if (effect.name != name) continue;
      ASSERT_EQ(effect.parameters.size(), truth.size());
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const ActiveEffect::Parameter& p = effect.parameters[i];
        EXPECT_NEAR(p.value, truth[i], 4.5 * p.sigma) << p.name;
        // Not as wide as such errors usually are: what the recording says of them.
        const double usual = name == "acc_scale_misalignment" ? 0.02 : 1e-3;
        EXPECT_LT(p.sigma, 0.15 * usual) << p.name;
      }
    }
  }
  EXPECT_LT(distance(c, s.truth.device), 60.0);
}

TEST(HandHeld, errors_that_a_part_does_not_have_are_not_estimated) {
  for (std::uint64_t seed = 72; seed <= 74; ++seed) {
    const oracle::Simulation s = simulate(realistic(oracle::MotionKind::kHandHeld, seed));
    const Calibration c = calibrate(s.recording);
    EXPECT_FALSE(has_effect(c, "acc_scale_misalignment")) << seed;
    EXPECT_FALSE(has_effect(c, "gyro_g_sensitivity")) << seed;
  }
}

// Turned about the vertical, a recording says little; with an older calibration of the device it is
// said what is known of both.
TEST(HandHeld, an_older_calibration_tells_what_a_level_turn_does_not) {
  const oracle::Options rich = realistic(oracle::MotionKind::kHandHeld, 75);
  const oracle::Simulation before = simulate(rich);
  oracle::Options poor = rich;
  poor.motion.kind = oracle::MotionKind::kLevel;
  const oracle::Simulation now = simulate(poor);
  CalibrationOptions options;
  EXPECT_EQ(calibrate(now.recording, options).trust.verdict, Verdict::kNo);
  auto given = std::make_shared<GivenPrior>();
  given->calibration = calibrate(before.recording);
  given->name = "older.json";
  given->age_days = 1.0;
  options.prior = PriorKind::kGiven;
  options.given_prior = given;
  const Calibration c = calibrate(now.recording, options);
  EXPECT_EQ(c.trust.verdict, Verdict::kLimited) << testing::PrintToString(c.trust.reasons);
  EXPECT_THAT(c.trust.reasons, testing::Contains(testing::HasSubstr("older.json")));
  for (int i = 0; i < 3; ++i) {
    const double sigma = c.sigma("magnetometers[0].bias[" + std::to_string(i) + "]");
    EXPECT_NEAR(c.parameters.mag[0].bias[i], now.truth.device.mag_bias[i], 4.0 * sigma);
  }
}

TEST(CalibrationOptions, what_no_data_could_make_up_for_is_refused) {
  const oracle::Simulation s = simulate(realistic(oracle::MotionKind::kRotation, 76));
  CalibrationOptions options;
  options.prior = PriorKind::kGiven;
  EXPECT_THROW(calibrate(s.recording, options), std::invalid_argument);
  options = {};
  options.gravity = 0.0;
  EXPECT_THROW(calibrate(s.recording, options), std::invalid_argument);
}

}  // namespace
}  // namespace magimu
