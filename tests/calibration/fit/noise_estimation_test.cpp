// SPDX-License-Identifier: BSD-3-Clause
// Noise densities where none are given.
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

TEST(NoiseEstimation, finds_the_densities_of_white_noise) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Simulation s = test::simulated_hand(100.0, seed);
    const Calibration c = calibrate(s.recording, test::same_model(s));
    EXPECT_FALSE(c.noise_given);
    EXPECT_NEAR(c.noise.acc / s.truth.noise.acc, 1.0, 0.05) << "seed " << seed;
    EXPECT_NEAR(c.noise.gyr / s.truth.noise.gyr, 1.0, 0.05) << "seed " << seed;
    EXPECT_NEAR(c.noise.mag / s.truth.noise.mag, 1.0, 0.05) << "seed " << seed;
  }
}

TEST(NoiseEstimation, needs_no_rests_for_accelerometer_and_magnetometer) {
  const Simulation s = test::simulated_paper(40.0, 4);
  const Calibration c = calibrate(s.recording, test::same_model(s, 2));
  EXPECT_NEAR(c.noise.acc / s.truth.noise.acc, 1.0, 0.05);
  EXPECT_NEAR(c.noise.mag / s.truth.noise.mag, 1.0, 0.05);
  EXPECT_NEAR(c.noise.gyr / s.truth.noise.gyr, 1.0, 0.25);
}

TEST(NoiseEstimation, costs_little_accuracy) {
  const Simulation s = test::simulated_hand(100.0, 2);
  const Calibration given = calibrate(s.recording, test::same_model_and_noise(s));
  const Calibration estimated = calibrate(s.recording, test::same_model(s));
  EXPECT_TRUE(given.noise_given);
  EXPECT_LT(test::sigmas_apart(given, estimated), 0.5);
  for (const ResidualSummary& residual : given.residuals) EXPECT_NEAR(residual.rms, 1.0, 0.1);
}

// Densities over the scales of real parts: a good one, and a cheap one.
TEST(NoiseEstimation, works_over_two_orders_of_magnitude) {
  for (const double factor : {0.1, 10.0}) {
    SimulationOptions options;
    options.motion = SimulatedMotion::kHand;
    options.rate_hz = 50.0;
    options.seed = 5;
    options.noise_factor = factor;
    const Simulation s = simulate(options);
    const Calibration c = calibrate(s.recording, test::same_model(s, 2));
    EXPECT_NEAR(c.noise.acc / s.truth.noise.acc, 1.0, 0.1) << "factor " << factor;
    EXPECT_NEAR(c.noise.gyr / s.truth.noise.gyr, 1.0, 0.2) << "factor " << factor;
    EXPECT_NEAR(c.noise.mag / s.truth.noise.mag, 1.0, 0.1) << "factor " << factor;
  }
}

}  // namespace
}  // namespace magimu
