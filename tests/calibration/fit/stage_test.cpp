// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "calibration/pipeline.h"
#include "solvers/back_ends.h"
#include "solvers/damped_factor.h"
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

// A global of few rows, as the lever arm is, must not send it to a general solver.
TEST(Stage, a_hand_held_model_is_eliminated_as_a_chain) {
  for (const double seconds : {12.0, 40.0, 120.0}) {
    SimulationOptions options;
    options.motion = SimulatedMotion::kHandHeld;
    options.rate_hz = 50.0;
    options.duration_s = seconds;
    const Simulation s = simulate(options);
    const Stage stage = coarse_stage(s, MotionModel::kHandHeld);
    LinearSystem system(stage.graph(), stage.result().values);
    system.linearize(stage.result().values);
    const auto solver = make_linear_solver(Backend::kChain);
    EXPECT_NO_THROW(solver->factorize(system, column_scale(system), 0.0)) << seconds << " s";
  }
}

}  // namespace
}  // namespace magimu
