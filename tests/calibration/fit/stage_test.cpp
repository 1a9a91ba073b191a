// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "calibration/pipeline.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

Stage coarse_stage(const Simulation& s, MotionModel motion) {
  const std::vector<const Recording*> recordings = {&s.recording};
  CalibrationOptions options = test::same_model(s);
  options.motion = motion;
  std::string reason;
  return Pipeline(recordings, options).coarse(reason);
}

// The last steps towards it are taken at once; a gyroscope's and a magnetometer's density settle
// slowly, each taking over what the other leaves unexplained.
TEST(Stage, noise_is_found_to_where_another_estimate_would_leave_it) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Simulation s = test::simulated_paper(80.0, seed);
    const Stage stage = coarse_stage(s, MotionModel::kRotation);
    const NoiseDensities found = stage.spec().noise, again = restricted_ml(found, stage.sums());
    EXPECT_NEAR(again.acc / found.acc, 1.0, 2e-3) << "seed " << seed;
    EXPECT_NEAR(again.gyr / found.gyr, 1.0, 2e-3) << "seed " << seed;
    EXPECT_NEAR(again.mag / found.mag, 1.0, 2e-3) << "seed " << seed;
  }
}

TEST(Stage, reach_of_the_hand_is_found_to_where_another_estimate_would_leave_it) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SimulationOptions options;
    options.motion = SimulatedMotion::kHandHeld;
    options.rate_hz = 100.0;
    options.seed = seed;
    const Simulation s = simulate(options);
    const Stage stage = coarse_stage(s, MotionModel::kHandHeld);
    EXPECT_NEAR(stage.sums().rms(Sensor::kReach), 1.0, 0.05) << "seed " << seed;
  }
}

}  // namespace
}  // namespace magimu
