// SPDX-License-Identifier: BSD-3-Clause
// Noise densities where none are given.
#include "calibration/motion/rests/rests.h"
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

// A trajectory of a moved sensor follows the gyroscope so closely that it has less than a hundredth
// of its rows left; these tell its noise.
TEST(NoiseEstimation, finds_the_gyroscopes_in_a_hand_that_never_rests) {
  double sum = 0.0;
  constexpr int kSeeds = 4;
  for (int seed = 0; seed < kSeeds; ++seed) {
    SimulationOptions options;
    options.motion = SimulatedMotion::kHandHeld;
    options.rate_hz = 50.0;
    options.duration_s = 180.0;
    options.displacement_m = 0.1;
    options.noise = {3e-3, 3e-4, 0.05};  // a usual part's, better than the paper's
    options.seed = 5601 + std::uint64_t(seed);
    const Simulation s = simulate(options);
    std::vector<Recording> moved;
    double from = s.recording.gyr.t.front();
    std::vector<TimeSpan> rests = find_rests(s.recording);
    const double end = s.recording.gyr.t.back();
    rests.push_back({end, end});
    for (const TimeSpan& rest : rests) {
      constexpr double kEdge = 1.5;  // s: where the hand slows down
      if (rest.begin_s - from > 10.0) {
        moved.push_back(slice(s.recording, from + kEdge, rest.begin_s - kEdge));
        EXPECT_TRUE(find_rests(moved.back()).empty()) << "seed " << options.seed;
      }
      from = rest.end_s;
    }
    ASSERT_GT(moved.size(), 3U);
    CalibrationOptions model = test::same_model(s);
    model.motion = MotionModel::kHandHeld;
    std::vector<const Recording*> recordings;
    for (const Recording& r : moved) recordings.push_back(&r);
    const Calibration c = calibrate(recordings, model);
    EXPECT_NEAR(std::log(c.noise.gyr / s.truth.noise.gyr), 0.0, 0.5) << "seed " << options.seed;
    sum += std::log(c.noise.gyr / s.truth.noise.gyr);
  }
  EXPECT_NEAR(sum / kSeeds, 0.0, 0.2);
}

}  // namespace
}  // namespace magimu
