// SPDX-License-Identifier: BSD-3-Clause
// Accelerometer samples that are a little off in time: the noise that follows from it, and the
// calibration of a hand-held sensor whose jolts are sampled so.
#include "calibration/motion/acc_jitter.h"

#include <gtest/gtest.h>

#include <random>

#include "calibration/pipeline.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

constexpr double kRest = 0.01;  // m/s^2 per sqrt(Hz)

VectorSeries steps_of(const std::vector<double>& sizes, double h) {
  VectorSeries acc;
  Vector3 a = Vector3::Zero();
  for (std::size_t k = 0; k <= sizes.size(); ++k) {
    acc.t.push_back(double(k) * h);
    acc.v.push_back(a);
    if (k < sizes.size()) a += Vector3::Constant(sizes[k]);
  }
  return acc;
}

TEST(AccJitter, at_rest_the_density_is_that_of_the_rest) {
  const VectorSeries acc = steps_of(std::vector<double>(8, 0.0), 0.01);
  EXPECT_EQ(acc_densities(acc, {0.0, 0.04, 0.08}, kRest, 1.0),
            (std::vector<double>{kRest, kRest, kRest}));
}

TEST(AccJitter, none_leaves_the_density_as_it_is) {
  const VectorSeries acc = steps_of(std::vector<double>(8, 1.0), 0.01);
  EXPECT_EQ(acc_densities(acc, {0.0, 0.08}, kRest, 0.0), (std::vector<double>{kRest, kRest}));
}

// Each axis steps by 1 and by 3 m/s^2: mean square 5, of which the noise itself makes 2 N^2 / h.
TEST(AccJitter, the_density_is_that_of_the_steps_in_the_interval) {
  const double h = 0.01;
  const VectorSeries acc = steps_of({0.0, 0.0, 1.0, 3.0}, h);
  const std::vector<double> d = acc_densities(acc, {0.0, 2.0 * h, 4.0 * h}, kRest, 0.5);
  EXPECT_DOUBLE_EQ(d[1], kRest);
  EXPECT_NEAR(d[2] * d[2], kRest * kRest + 0.25 * h * (5.0 - 2.0 * kRest * kRest / h), 1e-12);
}

TEST(AccJitter, an_interval_between_two_samples_has_the_step_across_it) {
  const VectorSeries acc = steps_of({0.0, 4.0, 0.0}, 0.1);
  const std::vector<double> d = acc_densities(acc, {0.12, 0.15, 0.18, 0.25}, kRest, 1.0);
  const double across = kRest * kRest + 0.1 * (16.0 - 2.0 * kRest * kRest / 0.1);
  EXPECT_NEAR(d[1] * d[1], across, 1e-12);
  EXPECT_NEAR(d[2] * d[2], across, 1e-12);
}

// Knocks, two a second while it turns: one sample reads several m/s^2 that never moved the sensor.
Recording knocked(Recording recording) {
  constexpr double kKnock = 8.0;  // m/s^2, per axis
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  constexpr double kTurning = 0.5;  // rad/s
  double next = recording.acc.t.front();
  for (std::size_t k = 0; k < recording.acc.size(); ++k) {
    if (recording.acc.t[k] < next || recording.gyr.v[k].norm() < kTurning) continue;
    next = recording.acc.t[k] + 0.5;
    recording.acc.v[k] += kKnock * Vector3(normal(random), normal(random), normal(random));
  }
  return recording;
}

double jitter_found(const Recording& recording, const CalibrationOptions& options) {
  const std::vector<const Recording*> recordings = {&recording};
  std::string why;
  return Pipeline(recordings, options).coarse(why).spec().acc_jitter;
}

TEST(AccJitter, is_found_where_jolts_are_and_only_there) {
  SimulationOptions simulated;
  simulated.motion = SimulatedMotion::kHandHeld;
  simulated.rate_hz = 100.0;
  simulated.duration_s = 90.0;
  const Simulation s = simulate(simulated);
  CalibrationOptions options;
  options.motion = MotionModel::kHandHeld;
  options.gravity = s.truth.gravity;
  EXPECT_EQ(jitter_found(s.recording, options), 0.0);

  const Recording jolted = knocked(s.recording);
  EXPECT_GE(jitter_found(jolted, options), 0.25);
  const Calibration c = calibrate(jolted, options);
  const VectorXd e = in_calibration_order(c).head(19) -
                     in_calibration_order(s.truth.parameters, {s.truth.parameters.dip_rad});
  EXPECT_LT(nees(e, c.covariance.topLeftCorner(19, 19)), 60.0);  // 19 expected
  EXPECT_LT(e.head<3>().norm(), 0.1);                            // o_a, m/s^2
}

}  // namespace
}  // namespace magimu
