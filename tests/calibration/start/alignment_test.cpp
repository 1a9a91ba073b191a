// SPDX-License-Identifier: BSD-3-Clause
// The pieces of the initialization that deal with rotations: alignment and attitude.
#include "calibration/start/alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "calibration/start/attitude.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

double angle_deg(const Rot3& a, const Rot3& b) { return (a.inverse() * b).Log().norm() / kDegree; }

// D = L mRb, L lower triangular with positive diagonal.
IntrinsicCalibration intrinsic_part(const MagnetometerParameters& mag) {
  IntrinsicCalibration out;
  out.distortion = Eigen::LLT<Matrix3>(mag.distortion * mag.distortion.transpose()).matrixL();
  out.bias = mag.bias;
  return out;
}

Rot3 rotation_part(const MagnetometerParameters& mag) {
  return Rot3::from_matrix(intrinsic_part(mag).distortion.inverse() * mag.distortion);
}

TEST(Alignment, recovers_rotation_and_gyroscope_bias_from_any_mounting) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Simulation s = test::simulated_hand(50.0, seed, 60.0);
    MagnetometerParameters mag = s.truth.parameters.mag.front();
    const Matrix3 Q = Rot3::Exp(Vector3(1.3 * double(seed), -0.7, 0.4 * double(seed))).matrix();
    mag = {Q * mag.distortion, Q * mag.bias};
    for (Vector3& v : s.recording.mag.front().v) v = Q * v;
    const Alignment found = align_magnetometer({&s.recording}, 0, intrinsic_part(mag));
    EXPECT_LT(angle_deg(found.mRb, rotation_part(mag)), 0.2) << "seed " << seed;
    EXPECT_LT((found.gyr_bias - s.truth.parameters.gyr_bias).norm(), 2e-3) << "seed " << seed;
    EXPECT_LT(found.residual_rms_rad, 0.01) << "seed " << seed;
  }
}

TEST(Alignment, leaves_a_given_gyroscope_bias_alone) {
  const Simulation s = test::simulated_hand(50.0, 2, 60.0);
  AlignmentOptions options;
  options.gyr_bias = s.truth.parameters.gyr_bias + Vector3(0.01, 0.0, 0.0);
  options.estimate_gyr_bias = false;
  const Alignment found = align_magnetometer(
      {&s.recording}, 0, intrinsic_part(s.truth.parameters.mag.front()), options);
  EXPECT_LT((found.gyr_bias - options.gyr_bias).norm(), 1e-6);
}

class Attitude : public testing::Test {
 protected:
  // The same device with its IMU axes called otherwise: v' = bQa v for all three sensors.
  static Simulation renamed(Simulation s, const Rot3& Q) {
    for (Vector3& v : s.recording.acc.v) v = Q * v;
    for (Vector3& v : s.recording.gyr.v) v = Q * v;
    SensorParameters& p = s.truth.parameters;
    p.acc_bias = Q * p.acc_bias;
    p.gyr_bias = Q * p.gyr_bias;
    p.mag.front().distortion = p.mag.front().distortion * Q.inverse().matrix();
    for (Rot3& nRb : s.truth.nRb) nRb = nRb * Q.inverse();
    return s;
  }

  static double attitude_rms_deg(const Simulation& s, const SensorParameters& p) {
    const IntegratedRotation gyr(s.recording.gyr, p.gyr_bias);
    const std::vector<Rot3> found = estimate_attitudes(s.recording, p, gyr, s.truth.t);
    EXPECT_EQ(found.size(), s.truth.nRb.size());
    double squares = 0.0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      squares += std::pow(angle_deg(found[k], s.truth.nRb[k]), 2);
    }
    return std::sqrt(squares / double(found.size()));
  }
};

TEST_F(Attitude, starts_within_a_few_degrees_from_any_first_attitude) {
  const Simulation level = test::simulated_hand(50.0, 5, 60.0);
  for (const Vector3& v : {Vector3(0, 0, 0), Vector3(M_PI, 0, 0), Vector3(1.57, 0, 0),
                           Vector3(0, -1.57, 0), Vector3(2.0, -1.0, 1.5), Vector3(0, 0, 3.1)}) {
    const Simulation s = renamed(level, Rot3::Exp(v));
    // Unknown, the accelerometer's bias tilts the vertical by up to 2 deg; the heading, which hangs
    // on the level part of a steep field, suffers three times as much.
    SensorParameters known = s.truth.parameters;
    EXPECT_LT(attitude_rms_deg(s, known), 1.5) << v.transpose();
    known.acc_bias.setZero();
    EXPECT_LT(attitude_rms_deg(s, known), 8.0) << v.transpose();
    const IntegratedRotation gyr(s.recording.gyr, known.gyr_bias);
    EXPECT_NEAR(estimate_dip(s.recording, known, gyr), s.truth.parameters.dip_rad, 3.0 * kDegree);
  }
}

TEST_F(Attitude, the_calibration_does_not_depend_on_the_first_attitude) {
  const Simulation level = test::simulated_hand(50.0, 5, 60.0);
  for (const Vector3& v : {Vector3(M_PI, 0, 0), Vector3(0, -1.57, 0), Vector3(2.0, -1.0, 1.5)}) {
    const Simulation s = renamed(level, Rot3::Exp(v));
    test::expect_consistent(calibrate(s.recording, test::same_model_and_noise(s, 4)),
                            s.truth.parameters);
  }
}

}  // namespace
}  // namespace magimu
