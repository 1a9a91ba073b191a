// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/real_results.h"

#include <gtest/gtest.h>

#include "sim/simulate.h"

namespace magimu {
namespace {

Calibration calibration_with(const Matrix3& distortion, const Vector3& mag_bias) {
  Calibration c;
  c.parameters.mag = {{distortion, mag_bias}};
  c.covariance = MatrixXd::Identity(19, 19);
  return c;
}

// D of some shape, and a covariance of some colour.
Calibration some_calibration() {
  Matrix3 D;
  D << 44.0, 2.0, -1.0, 0.5, 47.0, 3.0, 1.5, -2.0, 41.0;
  Calibration c = calibration_with(D, Vector3(1.0, 2.0, 3.0));
  MatrixXd root(19, 19);
  for (Eigen::Index i = 0; i < root.size(); ++i) root.data()[i] = std::sin(double(7 * i));
  c.covariance = root * root.transpose();
  return c;
}

TEST(NormalizedDistortion, has_the_covariance_of_its_numerical_derivative) {
  const Calibration c = some_calibration();
  const NormalizedDistortion n = normalized_distortion(c);
  EXPECT_NEAR(Matrix3(n.value.reshaped(3, 3)).determinant(), 1.0, 1e-12);
  constexpr double kStep = 1e-5;
  MatrixXd J(9, 9);
  for (Eigen::Index i = 0; i < 9; ++i) {
    Calibration above = c, below = c;
    above.parameters.mag[0].distortion.data()[i] += kStep;
    below.parameters.mag[0].distortion.data()[i] -= kStep;
    J.col(i) =
        (normalized_distortion(above).value - normalized_distortion(below).value) / (2.0 * kStep);
  }
  const MatrixXd expected = J * c.covariance.block<9, 9>(6, 6) * J.transpose();
  EXPECT_TRUE(n.covariance.isApprox(expected, 1e-6));
}

TEST(Repeatability, is_none_of_equal_calibrations_whatever_the_strength_of_the_field) {
  const Calibration a = some_calibration();
  Calibration b = a;
  b.parameters.mag[0].distortion *= 1.3;
  EXPECT_NEAR(repeatability({&a, &b}).all, 0.0, 1e-9);
  EXPECT_EQ(repeatability({&a}).all, 0.0);
}

TEST(Repeatability, counts_differences_in_standard_deviations_of_the_difference) {
  const Calibration a = calibration_with(50.0 * Matrix3::Identity(), Vector3::Zero());
  Calibration b = a;
  b.parameters.mag[0].bias = Vector3::Constant(std::sqrt(2.0) * 3.0);  // sigmas are 1 each
  const Repeatability r = repeatability({&a, &b});
  EXPECT_NEAR(r.mag_bias, 3.0, 1e-12);
  EXPECT_NEAR(r.acc_bias, 0.0, 1e-12);
  EXPECT_NEAR(r.all, 3.0 * std::sqrt(3.0 / 15.0), 1e-12);
  EXPECT_NEAR(r.difference[1][0], 3.0 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(r.difference[1][1], std::sqrt(2.0), 1e-12);
}

TEST(ErrorOverTime, is_the_error_of_each_stretch_and_no_number_where_there_is_no_truth) {
  TrajectoryEstimate estimate;
  MotionTruth truth;
  for (int k = 0; k <= 1000; ++k) {
    const double t = 0.01 * k, error_deg = t < 5.0 ? 2.0 : 3.0;
    estimate.t.push_back(t);
    estimate.nRb.push_back(Rot3::Exp(Vector3(0.0, 0.0, error_deg * kDegree)));
    truth.t.push_back(t);
    truth.nRb.emplace_back();
    truth.valid.push_back(t < 9.0);
  }
  const TimeSeries e = error_over_time(estimate, truth, 10);
  ASSERT_EQ(e.value.size(), 10u);
  EXPECT_NEAR(e.t[0], 0.5, 1e-9);
  EXPECT_NEAR(e.value[1], 2.0, 1e-9);
  EXPECT_NEAR(e.value[7], 3.0, 1e-9);
  EXPECT_TRUE(std::isnan(e.value[9]));
}

TEST(MagResidual, is_what_the_reading_has_beyond_the_model) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  options.noise_factor = 0.0;
  Simulation s = simulate(options);
  Calibration c;
  c.parameters = s.truth.parameters;
  c.trajectories = {{s.recording.name, s.truth.t, s.truth.nRb, {}, {}}};
  for (Vector3& v : s.recording.mag[0].v) v += Vector3(1.0, -2.0, 0.5);
  const auto residual = mag_residual_over_time(s.recording, c, 50);
  for (std::size_t b = 0; b < 50; ++b) {
    EXPECT_NEAR(residual[0].value[b], 1.0, 1e-6);
    EXPECT_NEAR(residual[1].value[b], -2.0, 1e-6);
    EXPECT_NEAR(residual[2].value[b], 0.5, 1e-6);
  }
}

TEST(ErrorParts, tell_a_shifted_clock_from_turned_frames) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 200.0;
  options.noise_factor = 0.0;
  Simulation s = simulate(options);
  Calibration c;
  c.parameters = s.truth.parameters;
  c.trajectories = {{s.recording.name, s.truth.t, s.truth.nRb, {}, {}}};
  MotionTruth& truth = *s.recording.truth;
  for (double& t : truth.t) t -= 0.004;
  ErrorParts parts = error_parts(s.recording, c);
  EXPECT_NEAR(parts.shift_ms, 4.0, 1e-9);
  EXPECT_GT(parts.delivered_deg, 0.1);
  EXPECT_LT(parts.shifted_deg, 1e-3);
  const Rot3 left = Rot3::Exp(Vector3(0.0, 0.0, 0.03)), right = Rot3::Exp(Vector3(0.02, 0.0, 0.0));
  for (Rot3& nRb : truth.nRb) nRb = left * nRb * right;
  parts = error_parts(s.recording, c);
  EXPECT_NEAR(parts.shift_ms, 4.0, 1.0);
  EXPECT_GT(parts.shifted_deg, 1.0);
  EXPECT_LT(parts.aligned_deg, 0.2);
}

TEST(RealResult, is_called_as_its_file_is) {
  RealResult r;
  r.recording.name = "07_undisturbed_fast_rotation_B.hdf5";
  EXPECT_EQ(r.number(), "07");
  EXPECT_EQ(r.name(), "fast rotation");
  r.recording.name = "33_disturbed_attached_magnet_2cm.hdf5";
  EXPECT_EQ(r.name(), "attached magnet 2cm");
  r.recording.name = "mine.csv";
  EXPECT_EQ(r.number(), "mine.csv");
}

}  // namespace
}  // namespace magimu
