// SPDX-License-Identifier: BSD-3-Clause
// The likelihood of left-out data decides between causes by a nat or two: it must be that of the
// data, not of rounding.
#include "diagnosis/held/held_out_nll.h"

#include <gtest/gtest.h>

#include "calibration/pipeline.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

// A moved sensor with a good gyroscope and accelerometer: in 5 s hardly anything says where it is.
Simulation moved_sensor() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.rate_hz = 100.0;
  options.duration_s = 100.0;
  options.noise = {.acc = 0.002, .gyr = 0.00015, .mag = 0.05};
  return simulate(options);
}

std::vector<double> with_gravity(const Simulation& s, double gravity) {
  const std::vector<const Recording*> recordings = {&s.recording};
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  options.gravity = gravity;
  const Stage stage = Pipeline(recordings, options).coarse_fit(MotionModel::kHandHeld);
  EXPECT_TRUE(stage.result().converged());
  return {sum_of(held_out_nll(stage, 5.0)), sum_of(held_out_nll(stage))};
}

TEST(HeldOutNll, of_a_moved_sensor_is_that_of_the_data_and_not_of_rounding) {
  const Simulation s = moved_sensor();
  const std::vector<double> nll = with_gravity(s, s.truth.gravity);
  for (const double change : {1e-13, 1e-12, -1e-12, 1e-11}) {
    const std::vector<double> again = with_gravity(s, s.truth.gravity * (1.0 + change));
    for (std::size_t i = 0; i < nll.size(); ++i) EXPECT_NEAR(again[i], nll[i], 0.02) << change;
  }
}

// Velocity and position over an interval have the gyroscope's noise, too: where the accelerometer
// is good, that is the larger part.
TEST(HeldOutNll, prefers_the_true_noise_of_a_moved_sensor) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.rate_hz = 100.0;
  options.duration_s = 75.0;
  options.noise = {.acc = 0.0006, .gyr = 7e-5, .mag = 0.015};
  const Simulation s = simulate(options);
  const std::vector<const Recording*> recordings = {&s.recording};
  const auto nll = [&](double times) {
    CalibrationOptions given = test::same_model_and_noise(s, 1);
    given.noise->gyr *= times;
    return sum_of(held_out_nll(Pipeline(recordings, given).coarse_fit(MotionModel::kHandHeld)));
  };
  const double truth = nll(1.0);
  for (const double times : {30.0, 100.0}) EXPECT_GT(nll(times), truth + 50.0) << times;
}

}  // namespace
}  // namespace magimu
