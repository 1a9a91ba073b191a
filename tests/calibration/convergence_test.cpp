// SPDX-License-Identifier: BSD-3-Clause
// From how far away the optimum is found.
#include <Eigen/LU>

#include "calibration/start/initialize.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using test::sigmas_apart;

constexpr double kSameOptimum = 1e-3;  // standard deviations

class FromAWrongGyroscopeBias : public testing::TestWithParam<double> {};

TEST_P(FromAWrongGyroscopeBias, every_direction_leads_to_the_same_optimum) {
  const Simulation s = test::simulated_hand(50.0, 3, 60.0);
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  const Calibration searched = calibrate(s.recording, options);
  test::expect_consistent(searched, s.truth.parameters);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vector3 error = sign * GetParam() * Vector3::Unit(axis);
      options.initialization.gyr_bias = s.truth.parameters.gyr_bias + error;
      const Calibration started = calibrate(s.recording, options);
      EXPECT_TRUE(started.fit.converged()) << started.fit.message;
      EXPECT_LT(sigmas_apart(searched, started), kSameOptimum)
          << "start off by " << error.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Convergence, FromAWrongGyroscopeBias, testing::Values(1e-3, 1e-2, 1e-1));

TEST(Convergence, the_start_of_the_dip_does_not_matter) {
  const Simulation s = test::simulated_hand(50.0, 4, 60.0);
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  const Calibration searched = calibrate(s.recording, options);
  for (const double dip_deg : {-80.0, -30.0, 0.0, 30.0, 89.0}) {
    options.initialization.dip_rad = dip_deg * kDegree;
    const Calibration started = calibrate(s.recording, options);
    EXPECT_LT(sigmas_apart(searched, started), kSameOptimum) << "start at " << dip_deg << " deg";
  }
}

StartPerturbation blind(std::uint64_t seed) {
  return {.seed = seed,
          .tilt_rad = 30.0 * kDegree,
          .heading_rad = 60.0 * kDegree,
          .distortion = 0.2,
          .mag_bias_uT = 5.0};
}

TEST(Convergence, a_blind_start_is_as_far_off_as_asked) {
  const Simulation s = test::simulated_hand(50.0, 4, 60.0);
  const InitialGuess guess = initialize({&s.recording}, {});
  const MagnetometerParameters& mag = guess.parameters.mag[0];
  EXPECT_EQ(guess.attitude_error.Log().norm(), 0.0);
  Rot3 first;
  for (const std::uint64_t seed : {1, 2, 3}) {
    InitializationOptions options;
    options.perturbation = blind(seed);
    const InitialGuess off = initialize({&s.recording}, options);
    const MagnetometerParameters& m = off.parameters.mag[0];
    EXPECT_NEAR((m.distortion - mag.distortion).norm(), 0.2 * mag.distortion.norm(), 1e-9);
    EXPECT_NEAR((m.bias - mag.bias).norm(), 5.0, 1e-9);
    const Vector3 up = off.attitude_error * Vector3(Vector3::UnitZ());
    EXPECT_NEAR(std::acos(up[2]), 30.0 * kDegree, 1e-9);
    EXPECT_GT((off.attitude_error * first.inverse()).Log().norm(), 0.1);  // from the seed before
    first = off.attitude_error;
  }
}

TEST(Convergence, blind_starts_end_in_the_same_minimum) {
  const Simulation s = test::simulated_hand(50.0, 4, 60.0);
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  for (const MotionModel motion : {MotionModel::kRotation, MotionModel::kHandHeld}) {
    options.motion = motion;
    const Calibration searched = calibrate(s.recording, options);
    for (const std::uint64_t seed : {1, 2, 3}) {
      options.initialization.perturbation = blind(seed);
      const Calibration started = calibrate(s.recording, options);
      EXPECT_LT(sigmas_apart(searched, started), 1e-2) << to_string(motion) << ", seed " << seed;
    }
    options.initialization.perturbation.reset();
  }
}

TEST(Convergence, a_large_bias_is_found_where_there_are_no_rests) {
  Simulation s = test::simulated_paper(10.0, 2);
  const Vector3 more(0.1, -0.15, 0.2);
  for (Vector3& rate : s.recording.gyr.v) rate += more;
  s.truth.parameters.gyr_bias += more;
  test::expect_consistent(calibrate(s.recording, test::same_model_and_noise(s)),
                          s.truth.parameters);
}

}  // namespace
}  // namespace magimu
