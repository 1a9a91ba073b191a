// SPDX-License-Identifier: BSD-3-Clause
// Checks on whether an estimate can be believed: each must fail where it ought to.
#include "calibration/fit/diagnostics.h"

#include <gmock/gmock.h>

#include <limits>
#include <map>

#include "calibration/calibrate_whole.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/motion/blows.h"
#include "tests/calibration/cases.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

Calibration with_covariance(double sigma) {
  Calibration c;
  c.parameters.mag.resize(1);
  c.parameters.mag[0].distortion = 45.0 * Matrix3::Identity();
  c.covariance = sigma * sigma * MatrixXd::Identity(19, 19);
  return c;
}

TEST(Checks, equal_halves_agree_and_others_are_told_apart_in_sigmas) {
  const Calibration a = with_covariance(0.1);
  EXPECT_EQ(check_halves(a, a).value, 0.0);
  EXPECT_EQ(check_halves(a, a).status, CheckStatus::kOk);
  Calibration b = with_covariance(0.1);
  for (double& x : b.parameters.mag[0].distortion.reshaped()) x += 0.5;
  for (double& x : b.parameters.mag[0].bias) x -= 0.5;
  const Check check = check_halves(a, b);
  EXPECT_NEAR(check.value, 0.5 / (0.1 * std::sqrt(2.0)), 1e-12);
  EXPECT_EQ(check.status, CheckStatus::kCaution);
  EXPECT_THAT(check.sentence, testing::HasSubstr("disagree"));
}

// Along an axis of the field the sigma of its direction is that of one column of D and of o_m,
// sqrt(2) s / 45; along a diagonal the same, columns weighing a third each.
TEST(Checks, accuracy_is_the_angle_that_distortion_and_bias_leave_open) {
  const Check check = check_accuracy(with_covariance(0.3));
  EXPECT_NEAR(check.value, std::sqrt(2.0) * 0.3 / 45.0 / kDegree, 1e-9);
  EXPECT_EQ(check.status, CheckStatus::kOk);
  EXPECT_EQ(check_accuracy(with_covariance(3.0)).status, CheckStatus::kBad);
}

// What `info` counts as visited a check does not call hardly visited.
TEST(Checks, accuracy_blames_the_motion_only_where_an_attitude_is_missing) {
  Calibration c = with_covariance(0.01);
  c.covariance(7, 7) = 9.0;  // of D's first column: the field along x seems to have a y
  c.fields.resize(1);
  c.trajectories.resize(1);
  const Vector3 x = Vector3::UnitX(), north = Vector3::UnitY();
  EXPECT_THAT(check_accuracy(c).sentence, testing::HasSubstr("hardly visited"));
  for (const double sign : {1.0, -1.0}) {
    c.trajectories[0].nRb.push_back(Rot3::Exp(Vector3(0.0, 0.0, sign * M_PI / 2.0)));
    const Vector3 field = c.trajectories[0].nRb.back().unrotate(north);
    EXPECT_NEAR(std::abs(field.dot(x)), 1.0, 1e-12);
  }
  EXPECT_TRUE(field_came_near(c, x));
  EXPECT_FALSE(field_came_near(c, north));
  EXPECT_THAT(check_accuracy(c).sentence, testing::HasSubstr("what the model lacks"));
}

TEST(Checks, a_window_that_does_not_fit_is_counted) {
  Calibration c;
  c.trajectories.resize(1);
  std::vector<double> squares;
  for (int i = 0; i < 801; ++i) {
    c.trajectories[0].t.push_back(0.125 * i);
    squares.push_back(i >= 320 && i < 360 ? 30.0 : 3.0);
  }
  const Check check = check_windows(c, squares);
  EXPECT_NEAR(check.value, 1.0 / 20.0, 1e-12);
  EXPECT_EQ(check.status, CheckStatus::kCaution);
  EXPECT_THAT(check.sentence, testing::HasSubstr("1 of 20 windows"));
}

TEST(Checks, left_out_data_are_weighed_against_the_field) {
  // 100 and 300 uT^2 over 400 values: 1 uT, of a field of 50.
  const BlockErrors good{{100.0, 300.0}, {100.0, 100.0}, 400.0};
  EXPECT_NEAR(check_held_out(good, 50.0).value, 0.02, 1e-12);
  EXPECT_EQ(check_held_out(good, 50.0).status, CheckStatus::kOk);
  EXPECT_EQ(check_held_out({{40000.0}, {100.0}, 400.0}, 50.0).status, CheckStatus::kBad);
}

TEST(Checks, a_fit_that_did_not_converge_is_bad) {
  Result fit;
  fit.reason = StopReason::kMaxIterations;
  EXPECT_EQ(check_optimum(fit).status, CheckStatus::kBad);
}

std::map<std::string, Check> checks_of(const std::vector<oracle::Effect>& effects) {
  oracle::Options options;
  options.rate_hz = 50.0;
  options.motion.duration_s = 90.0;
  options.device_kind = oracle::DeviceKind::kBoard;
  options.noise = oracle::kRealisticDensities;
  options.effects = effects;
  std::map<std::string, Check> out;
  const Recording recording = simulate(options).recording;
  for (const Check& check : calibrate_whole({&recording}).checks) out[check.name] = check;
  return out;
}

TEST(Checks, of_a_clean_recording_are_all_in_order) {
  const auto checks = checks_of({});
  for (const auto& [name, check] : checks) {
    EXPECT_EQ(check.status, CheckStatus::kOk) << name << ": " << check.sentence;
  }
  // 0.05 uT per sqrt(Hz) in means of a tenth of a second are 0.158 uT; the prediction adds some.
  const double error_uT = checks.at("cross_validation").value * 48.0;
  EXPECT_GT(error_uT, 0.15);
  EXPECT_LT(error_uT, 0.5);
}

TEST(Blows, taps_are_counted_and_swings_are_not) {
  Recording r;
  for (int k = 0; k < 6000; ++k) {  // a minute; 20 m/s^2 of swing at 1.5 Hz
    const double t = 0.01 * k, tap = k % 600 == 300 ? 40.0 : 0.0;
    r.acc.push_back(t, Vector3(20.0 * std::sin(9.4 * t), tap, 9.8));
    r.gyr.push_back(t, Vector3::Zero());
  }
  EXPECT_NEAR(blows_per_minute(r), 10.0, 0.01);
}

TEST(Uncertainty, is_widened_in_every_place_it_is_told) {
  Calibration c = with_covariance(0.3);
  c.covariance = 0.09 * MatrixXd::Identity(20, 20);
  c.order.assign(19, "");
  c.order.push_back("offset");
  c.fields.resize(1);
  c.strength_uT = 45.0;
  c.effects = {{"mag_time_offset", {{"offset", "s", 0.01, 0.3, 0.0005}}}};
  widen_uncertainty(c, 2.0);
  EXPECT_NEAR(c.covariance(0, 0), 0.36, 1e-15);
  EXPECT_NEAR(c.strength_sigma_uT, 0.6 / std::sqrt(3.0), 1e-12);  // a third of D's trace
  EXPECT_NEAR(c.fields[0].dip_sigma_rad, 0.6 * kDegree, 1e-15);
  EXPECT_NEAR(c.effects[0].parameters[0].sigma, 0.6, 1e-15);
  EXPECT_EQ(c.effects[0].parameters[0].sigma_model, 0.0005);
}

TEST(Checks, a_magnet_attached_half_way_shows_in_the_residuals) {
  const double forever = std::numeric_limits<double>::infinity();
  auto checks =
      checks_of({oracle::make_effect("hard_iron_change", {4.0, -3.0, 2.0, 45.0, forever})});
  EXPECT_NE(checks["whiteness"].status, CheckStatus::kOk);
  EXPECT_GT(checks["halves"].value, 2.0) << checks["halves"].sentence;
}

}  // namespace
}  // namespace magimu
