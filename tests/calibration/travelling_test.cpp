// SPDX-License-Identifier: BSD-3-Clause
// A sensor that is turned while its bearer walks, rides or flies is recognised without an option,
// and its errors agree with the covariance. A hand that stays in its place is not taken for travel.
#include <gmock/gmock.h>

#include <cmath>

#include "calibration/calibrate.h"
#include "calibration/travelling.h"
#include "sim/simulate.h"
#include "tests/calibration/cases.h"
#include "tests/calibration/truth_distance.h"

namespace magimu {
namespace {

Simulation travelled(std::uint64_t seed, double speed_mps) {
  SimulationOptions o;
  o.motion = SimulatedMotion::kHandHeld;
  o.rate_hz = 50.0;
  o.seed = seed;
  o.speed_mps = speed_mps;
  o.gravity = CalibrationOptions().gravity;
  return simulate(o);
}

// e' P^-1 e of the 19 parameters.
double squares_from_truth(const Calibration& c, const SensorParameters& truth) {
  const VectorXd e =
      in_calibration_order(c).head(19) - in_calibration_order(truth, {truth.dip_rad});
  return e.dot(c.covariance.topLeftCorner(19, 19).ldlt().solve(e));
}

TEST(Travelling, walks_and_rides_are_recognised_and_calibrated) {
  for (const double speed : {1.4, 12.0}) {
    for (const std::uint64_t seed : {46001u, 46002u}) {
      const Simulation s = travelled(seed, speed);
      const Calibration c = calibrate(s.recording);
      EXPECT_EQ(c.motion, MotionModel::kTravelling) << speed << " m/s, seed " << seed;
      EXPECT_THAT(c.motion_reason, testing::HasSubstr("travelled"));
      EXPECT_NE(c.trust.verdict, Verdict::kNo) << c.trust.reasons.front();
      EXPECT_LT(squares_from_truth(c, s.truth.parameters), test::kOutside);
      EXPECT_GT(c.speed_mps, 0.2 * speed);
      EXPECT_LT(c.speed_mps, 2.0 * speed);
      EXPECT_TRUE(c.lever_arms.empty());
    }
  }
}

TEST(Travelling, a_hand_that_stays_is_not_taken_for_it) {
  for (const std::uint64_t seed : {46011u, 46012u}) {
    const Simulation s = travelled(seed, 0.0);
    EXPECT_EQ(calibrate(s.recording).motion, MotionModel::kHandHeld) << seed;
  }
}

// A low-pass of first order, at 4 Hz with this time constant.
void slow_down(VectorSeries& acc, double tau_s) {
  for (std::size_t i = 1; i < acc.size(); ++i) {
    const double kept = std::exp(-(acc.t[i] - acc.t[i - 1]) / tau_s);
    acc.v[i] = kept * acc.v[i - 1] + (1.0 - kept) * acc.v[i];
  }
}

// What it reads while it turns belongs to another attitude: taken at its word, a hand would have
// been metres away.
TEST(Travelling, a_slow_accelerometer_in_a_hand_is_not_taken_for_it) {
  for (const std::uint64_t seed : {49011u, 49012u, 49013u}) {
    Simulation s = travelled(seed, 0.0);
    slow_down(s.recording.acc, 0.04);
    const Calibration c = calibrate(s.recording);
    EXPECT_EQ(c.motion, MotionModel::kHandHeld) << seed << ": " << c.motion_reason;
    EXPECT_EQ(c.motion_reason.find("travelled"), std::string::npos);
  }
}

// Positions add up to kilometres and are known to micrometres from node to node: without a loose
// bound the fast back end had no digits left for the bias (sigmas ten times too small).
TEST(Travelling, the_fast_back_end_has_the_sigmas_of_the_general_one) {
  const Simulation s = travelled(46021, 12.0);
  CalibrationOptions options;
  options.motion = MotionModel::kTravelling;
  options.noise = s.truth.noise;
  const Calibration fast = calibrate(s.recording, options);
  options.optimizer.backend = Backend::kCholmod;
  const Calibration general = calibrate(s.recording, options);
  const Eigen::Index n = general.covariance_model.rows();
  ASSERT_EQ(fast.covariance_model.rows(), n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double sigma = std::sqrt(general.covariance_model(i, i));
    EXPECT_NEAR(std::sqrt(fast.covariance_model(i, i)), sigma, 0.01 * sigma)
        << general.order[std::size_t(i)];
  }
}

}  // namespace
}  // namespace magimu
