// SPDX-License-Identifier: BSD-3-Clause
// A misfit is laid to a magnet only where nothing else is known of it.
#include "calibration/scan/misfit_cause.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include "calibration/calibrate.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kRate = 50.0;
constexpr std::size_t kReadings = 4000;

std::vector<Vector3> noise(double size) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, size);
  std::vector<Vector3> out;
  for (std::size_t k = 0; k < kReadings; ++k) {
    const double x = normal(random), y = normal(random), z = normal(random);
    out.emplace_back(x, y, z);
  }
  return out;
}

std::vector<double> times() {
  std::vector<double> t;
  for (std::size_t k = 0; k < kReadings; ++k) t.push_back(double(k) / kRate);
  return t;
}

Calibration with_residuals(const std::vector<Vector3>& whitened) {
  Calibration c;
  c.residual_series.resize(3);
  c.residual_series[2] = {.sensor = "mag", .t = times(), .whitened = whitened};
  return c;
}

TEST(MisfitCause, of_noise_alone_nothing_is_said) {
  const std::vector<Vector3> whitened = noise(2.0);
  EXPECT_LT(outlying_readings(whitened).share, 0.02);
  EXPECT_LT(strongest_line(times(), whitened).share, 0.1);
  EXPECT_EQ(cause_of_misfit(with_residuals(whitened), {}), "");
}

TEST(MisfitCause, single_readings_that_stand_out_are_counted) {
  std::vector<Vector3> whitened = noise(1.0);
  for (std::size_t k = 50; k < kReadings; k += 100) whitened[k] += Vector3(20.0, -20.0, 15.0);
  const OutlyingReadings out = outlying_readings(whitened);
  EXPECT_EQ(out.count, kReadings / 100);
  EXPECT_GT(out.share, 0.5);
  const std::string said = cause_of_misfit(with_residuals(whitened), {});
  EXPECT_THAT(said, HasSubstr("40 single readings"));
  EXPECT_THAT(said, Not(HasSubstr("iron")));
}

TEST(MisfitCause, what_lasts_is_no_single_reading) {
  std::vector<Vector3> whitened = noise(1.0);
  for (std::size_t k = 1000; k < 1100; ++k) whitened[k] += Vector3(20.0, -20.0, 15.0);
  EXPECT_LT(outlying_readings(whitened).share, 0.1);
  EXPECT_EQ(cause_of_misfit(with_residuals(whitened), {}), "");
}

TEST(MisfitCause, a_line_is_measured_and_the_mains_are_recognised) {
  std::vector<Vector3> whitened = noise(1.0);
  const std::vector<double> t = times();
  for (std::size_t k = 0; k < kReadings; ++k) {
    whitened[k] += std::sin(2.0 * std::numbers::pi * 60.07 * t[k]) * Vector3(3.0, 1.0, -2.0);
  }
  const StrongestLine line = strongest_line(t, whitened);
  EXPECT_NEAR(line.hz, 10.07, 0.03);
  EXPECT_GT(line.share, 0.5);
  EXPECT_THAT(cause_of_misfit(with_residuals(whitened), {}), HasSubstr("the mains' 60 Hz"));
}

TEST(MisfitCause, a_column_is_named_only_where_it_explains_most) {
  MissingEffect current;
  current.name = "mag_current";
  current.cause = "a current on the device makes a field of its own";
  current.needs = "current";
  const Calibration c = with_residuals(noise(2.0));
  current.share_of_misfit = 0.3;
  EXPECT_EQ(cause_of_misfit(c, {current}), "");
  current.share_of_misfit = 0.8;
  EXPECT_THAT(cause_of_misfit(c, {current}), HasSubstr("column current explains most of it"));
}

TEST(MisfitCause, calibrate_says_that_a_recorded_current_does_it) {
  oracle::Options o;
  o.seed = 5;
  o.rate_hz = 50.0;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.noise = oracle::kRealisticDensities;
  o.motion.duration_s = 90.0;
  o.record_current = true;
  o.effects = {oracle::make_effect("mag_current", {2.0, -1.5, 1.0})};
  const Calibration c = calibrate(oracle::simulate(o).recording);
  ASSERT_NE(c.trust.verdict, Verdict::kYes);
  EXPECT_THAT(c.trust.reasons, testing::Contains(HasSubstr("column current explains")));
  EXPECT_THAT(c.trust.reasons, testing::Each(Not(HasSubstr("Go away from iron"))));
}

}  // namespace
}  // namespace magimu
