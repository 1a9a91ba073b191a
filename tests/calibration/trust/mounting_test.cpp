// SPDX-License-Identifier: BSD-3-Clause
// However the magnetometer is mounted, the same device comes out; and which of two
// indistinguishable answers is given where the data cannot tell.
#include <Eigen/LU>

#include "tests/calibration/cases.h"

namespace magimu {
namespace {

Matrix3 axes(const Vector3& x, const Vector3& y, const Vector3& z) {
  Matrix3 m;
  m << x, y, z;
  return m;
}

// The recording of a magnetometer whose readings are Q times those of s.
Recording mounted(const Simulation& s, const Matrix3& Q) {
  Recording out = s.recording;
  for (Vector3& v : out.mag.front().v) v = Q * v;
  return out;
}

class AnyMounting : public testing::Test {
 protected:
  const Simulation s_ = test::simulated_hand(50.0, 21, 60.0);
  // Of the likelihood: what is usual of parts knows of 24 mountings only.
  const CalibrationOptions options_ = [this] {
    CalibrationOptions options = test::same_model_and_noise(s_, 4);
    options.prior = PriorKind::kNone;
    return options;
  }();
  const Calibration straight_ = calibrate(s_.recording, options_);

  // What straight_ says, with this distortion, bias and dip instead.
  VectorXd expected(const Matrix3& D, const Vector3& bias, double dip_rad) const {
    SensorParameters p = straight_.parameters;
    p.mag.front() = {D, bias};
    return in_calibration_order(p, {dip_rad});
  }
  const Matrix3& D() const { return straight_.parameters.mag.front().distortion; }
  const Vector3& bias() const { return straight_.parameters.mag.front().bias; }
  double dip() const { return straight_.parameters.dip_rad; }
};

TEST_F(AnyMounting, permuted_axes_are_found) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  for (const Matrix3& Q : {axes(y, z, x), axes(-x, -y, z), axes(y, x, -z), axes(-z, y, x)}) {
    ASSERT_NEAR(Q.determinant(), 1.0, 1e-15);
    const Calibration c = calibrate(mounted(s_, Q), options_);
    EXPECT_TRUE(c.fit.converged()) << c.fit.message;
    EXPECT_LT(test::sigmas_apart(c, expected(Q * D(), Q * bias(), dip())), 1e-3) << Q;
  }
}

TEST_F(AnyMounting, any_rotation_is_found) {
  for (const Vector3& v :
       {Vector3(0.7, -0.2, 0.4), Vector3(-1.5, 2.0, 0.3), Vector3(0, 0, 0.785)}) {
    const Matrix3 Q = Rot3::Exp(v).matrix();
    const Calibration c = calibrate(mounted(s_, Q), options_);
    EXPECT_LT(test::sigmas_apart(c, expected(Q * D(), Q * bias(), dip())), 1e-3) << v.transpose();
  }
}

TEST_F(AnyMounting, an_odd_inversion_gives_the_opposite_dip_and_a_positive_determinant) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  for (const Matrix3& Q : {axes(x, y, -z), axes(-x, y, z), axes(y, x, z), axes(-x, -y, -z)}) {
    ASSERT_NEAR(Q.determinant(), -1.0, 1e-15);
    const Calibration c = calibrate(mounted(s_, Q), options_);
    EXPECT_TRUE(c.fit.converged()) << c.fit.message;
    EXPECT_GT(c.parameters.mag.front().distortion.determinant(), 0.0);
    EXPECT_GT(c.strength_uT, 0.0);
    EXPECT_LT(test::sigmas_apart(c, expected(-Q * D(), Q * bias(), -dip())), 1e-3) << Q;
    // The attitude turns with it, by half a turn about the vertical.
    const Rot3 turn = c.trajectories[0].nRb[9] * straight_.trajectories[0].nRb[9].inverse();
    EXPECT_LT((turn.matrix() - Vector3(-1, -1, 1).asDiagonal().toDenseMatrix()).norm(), 1e-4);
  }
}

TEST(Array, magnetometers_may_be_inverted_against_each_other) {
  Simulation s = test::simulated_hand(50.0, 8, 60.0, 1, 3);
  for (Vector3& v : s.recording.mag[1].v) v[2] = -v[2];
  MagnetometerParameters& second = s.truth.parameters.mag[1];
  second.distortion.row(2) *= -1.0;
  second.bias[2] *= -1.0;
  test::expect_consistent(calibrate(s.recording, test::same_model_and_noise(s, 4)),
                          s.truth.parameters);
}

TEST_F(AnyMounting, a_start_on_the_other_side_of_the_vertical_ends_with_a_positive_cosine) {
  CalibrationOptions options = options_;
  options.initialization.dip_rad = M_PI - dip();
  const Calibration c = calibrate(s_.recording, options);
  EXPECT_GT(std::cos(c.parameters.dip_rad), 0.0);
  EXPECT_LT(test::sigmas_apart(straight_, c), 1e-3);
}

}  // namespace
}  // namespace magimu
