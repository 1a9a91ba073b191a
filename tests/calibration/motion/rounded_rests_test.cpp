// SPDX-License-Identifier: BSD-3-Clause
// A resting sensor behind a coarse converter: what its mean is worth, against drawn readings.
#include "calibration/motion/rounded_rests.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/calibrate.h"
#include "factors/effects/noise_effects.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

constexpr double kStep = 0.6;

// Of means of so many readings at random places between two levels.
double drawn_variance(double sigma, int samples) {
  constexpr int kPlaces = 20000;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> place(0.0, kStep);
  std::normal_distribution<double> noise(0.0, 1.0);
  double sum = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    const double x = place(random);
    double mean = 0.0;
    for (int k = 0; k < samples; ++k) {
      mean += kStep * std::round((x + sigma * noise(random)) / kStep) / samples;
    }
    sum += (mean - x) * (mean - x);
  }
  return sum / kPlaces;
}

class RoundedMean : public testing::TestWithParam<double> {};

TEST_P(RoundedMean, is_as_good_as_that_of_its_independent_readings) {
  const double sigma = GetParam() * kStep;
  const double single = sigma * sigma + kStep * kStep / 12.0;
  for (const int samples : {1, 4, 30}) {
    const double readings = independent_readings(kStep, sigma, samples);
    EXPECT_NEAR(drawn_variance(sigma, samples) / (single / readings), 1.0, 0.04) << samples;
  }
}

TEST_P(RoundedMean, tells_the_noise_before_it_was_rounded) {
  const double sigma = GetParam() * kStep;
  const double scatter =
      std::sqrt(sigma * sigma + kStep * kStep / 12.0 - rounded_mean_variance(kStep, sigma));
  EXPECT_NEAR(sigma_before_rounding(kStep, scatter), sigma, 1e-6 * kStep);
}

INSTANTIATE_TEST_SUITE_P(Sigma, RoundedMean, testing::Values(0.02, 0.1, 0.2, 0.5, 2.0));

Simulation with_rests(std::uint64_t seed) {
  SimulationOptions o;
  o.motion = SimulatedMotion::kHand;
  o.rate_hz = 50.0;
  o.duration_s = 60.0;
  o.seed = seed;
  return simulate(o);
}

TEST(IndependentShares, are_all_where_the_steps_are_finer_than_the_noise) {
  Simulation s = with_rests(1);
  EXPECT_TRUE(independent_shares(s.recording, s.recording.mag[0].t).empty());
}

TEST(IndependentShares, are_few_where_a_coarse_converter_rests_and_all_where_it_turns) {
  Simulation s = with_rests(1);
  quantize(s.recording.mag[0].v, 1.5);
  const std::vector<double>& t = s.recording.mag[0].t;
  const auto shares = independent_shares(s.recording, t);
  ASSERT_EQ(shares.size(), 1U);
  double resting = 0.0, turning = 0.0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (t[k] < 2.5) resting += shares[0][k];
    if (t[k] > 10.0 && t[k] < 20.0) turning += shares[0][k];
  }
  EXPECT_LT(resting, 5.0);    // of 125
  EXPECT_GT(turning, 450.0);  // of 500
}

// The errors are judged by what the fit says of them.
TEST(CoarseConverters, leave_the_calibration_within_its_sigmas) {
  double sum = 0.0;
  int n = 0;
  for (std::uint64_t seed = 31; seed < 39; ++seed) {
    Simulation s = with_rests(seed);
    quantize(s.recording.mag[0].v, 1.5);
    const Calibration c = calibrate(s.recording);
    const Vector3 error = c.parameters.mag[0].bias - s.truth.parameters.mag[0].bias;
    for (int axis = 0; axis < 3; ++axis) {
      const auto name = fmt::format("magnetometers[0].bias[{}]", axis);
      const auto at = std::ranges::find(c.order, name) - c.order.begin();
      ASSERT_LT(at, std::ssize(c.order));
      sum += error[axis] * error[axis] / c.covariance(at, at);
    }
    n += 3;
  }
  EXPECT_LT(sum / n, 2.0);
}

}  // namespace
}  // namespace magimu
