// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/orientation_filter.h"

#include <gtest/gtest.h>

#include "calibration/trust/orientation_error.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

Simulation simulated_turns(double noise_factor = 1.0) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  options.noise_factor = noise_factor;
  return simulate(options);
}

double error_deg(const Simulation& s, const SensorParameters& parameters, double lag_s = 0.0) {
  return orientation_error(track(s.recording, {.parameters = parameters, .mag_lag_s = lag_s}),
                           *s.recording.truth)
      .total_deg;
}

TEST(OrientationFilter, exact_readings_and_parameters_give_the_orientation) {
  const Simulation s = simulated_turns(0.0);
  EXPECT_LT(error_deg(s, s.truth.parameters), 0.02);
}

TEST(OrientationFilter, noise_matters_little_and_a_missing_calibration_much) {
  const Simulation s = simulated_turns();
  EXPECT_LT(error_deg(s, s.truth.parameters), 0.3);
  EXPECT_GT(error_deg(s, {}), 3.0);
}

TEST(OrientationFilter, every_group_of_parameters_counts) {
  const Simulation s = simulated_turns(0.0);
  const SensorParameters& truth = s.truth.parameters;
  SensorParameters p = truth;
  p.acc_bias += Vector3(0.2, 0.0, 0.0);
  EXPECT_GT(error_deg(s, p), 0.5);
  p = truth;
  p.mag[0].bias += Vector3(5.0, 0.0, 0.0);
  EXPECT_GT(error_deg(s, p), 0.5);
  p = truth;
  p.mag[0].distortion *= Rot3::Exp(Vector3(0.0, 0.1, 0.0)).matrix();
  EXPECT_GT(error_deg(s, p), 0.5);
  p = truth;
  p.gyr_bias += Vector3(0.02, 0.0, 0.0);
  EXPECT_GT(error_deg(s, p), 0.5);
}

TEST(OrientationFilter, the_strength_of_the_field_is_of_no_matter) {
  const Simulation s = simulated_turns();
  SensorParameters p = s.truth.parameters;
  p.mag[0].distortion *= 3.0;
  EXPECT_NEAR(error_deg(s, p), error_deg(s, s.truth.parameters), 1e-9);
}

TEST(OrientationFilter, a_lag_of_the_magnetometer_is_taken_back) {
  constexpr double kLag = 0.05;  // s
  Simulation s = simulated_turns(0.0);
  for (double& t : s.recording.mag[0].t) t += kLag;
  EXPECT_LT(error_deg(s, s.truth.parameters, kLag), 0.05);
  EXPECT_GT(error_deg(s, s.truth.parameters), 0.1);
}

TEST(OrientationFilter, scale_errors_of_the_gyroscope_are_taken_back) {
  Simulation s = simulated_turns(0.0);
  const Vector3 bias = s.truth.parameters.gyr_bias;
  for (Vector3& v : s.recording.gyr.v) v = 1.05 * (v - bias) + bias;
  Corrections c{.parameters = s.truth.parameters};
  const double before = orientation_error(track(s.recording, c), *s.recording.truth).total_deg;
  Calibration calibration;
  calibration.parameters = s.truth.parameters;
  calibration.effects = {{"gyro_scale_misalignment", {}}};
  for (int e = 0; e < 9; ++e) {
    const double value = e % 4 == 0 ? 0.05 : 0.0;
    calibration.effects[0].parameters.push_back({"", "1", value});
  }
  c = corrections(calibration);
  EXPECT_GT(before, 1.0);
  EXPECT_LT(orientation_error(track(s.recording, c), *s.recording.truth).total_deg, 0.02);
}

}  // namespace
}  // namespace magimu
