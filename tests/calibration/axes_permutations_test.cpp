// SPDX-License-Identifier: BSD-3-Clause
// The 48 signed permutations of one sensor's axes, simulated and real: each is found, or declared
// as one of two that no motion can tell apart, and none is accepted in silence.
#include <gmock/gmock.h>

#include <Eigen/LU>
#include <filesystem>

#include "calibration/trust/check_axes.h"
#include "calibration/trust/mounting.h"
#include "recording/data/axes.h"
#include "recording/read.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using testing::HasSubstr;
using testing::Not;

const Recording& simulated() {
  static const Recording recording = test::simulated_hand(50.0, 21, 60.0).recording;
  return recording;
}

// BROAD 02, or nothing where it is absent.
const std::optional<Recording>& real() {
  static const std::optional<Recording> recording = []() -> std::optional<Recording> {
    const auto path =
        std::filesystem::path(MAGIMU_DATA_DIR) / "broad" / "02_undisturbed_slow_rotation_B.hdf5";
    if (!std::filesystem::exists(path)) return std::nullopt;
    return read_recording(path.string());
  }();
  return recording;
}

Recording turned(const Recording& original, const std::string& sensor, const Matrix3& Q) {
  Recording out = original;
  turn_axes(out, sensor, Q);
  return out;
}

// A sensor that reads Q u where it should read u. Q and -Q fit alike, so what is found is the one
// of the two that is a rotation, and where that is none, nothing is found: the accelerometer and
// the magnetometer may then be as they should be, or wholly inverted, which check_axes says.
void expect_found(const Recording& original, const std::string& sensor) {
  for (const Matrix3& Q : signed_permutations()) {
    SCOPED_TRACE(sensor + " " + axes_text(Q));
    const Mounting m = check_mounting(turned(original, sensor, Q));
    const Matrix3 rotation = sensor == "gyr" || Q.determinant() > 0.0 ? Q : Matrix3(-Q);
    if (rotation.isIdentity()) {
      EXPECT_EQ(m.status, MountingStatus::kConsistent) << m.sentence;
      const Check check = check_axes(m, Matrix3::Identity(), 1.0, 0);
      EXPECT_THAT(check.sentence, HasSubstr("which no motion can tell"));
      continue;
    }
    EXPECT_EQ(m.status, MountingStatus::kTurned) << m.sentence;
    ASSERT_EQ(m.findings.size(), 1u) << m.sentence;
    EXPECT_EQ(m.findings[0].sensor, sensor);
    EXPECT_EQ(m.findings[0].remedy, rotation.transpose()) << m.sentence;
    EXPECT_EQ(m.findings[0].or_inverted, sensor != "gyr");
    EXPECT_THAT(m.sentence, HasSubstr("--axes " + sensor + "=" + axes_text(rotation.transpose())));
    EXPECT_NE(check_axes(m, Matrix3::Identity(), 1.0, 0).status, CheckStatus::kOk);
  }
}

class AxesPermutations : public testing::TestWithParam<const char*> {};

TEST_P(AxesPermutations, of_a_simulated_sensor_are_found_or_declared) {
  expect_found(simulated(), GetParam());
}

TEST_P(AxesPermutations, of_a_real_sensor_are_found_or_declared) {
  if (!real()) GTEST_SKIP() << "This test needs BROAD 02, which is not part of the project.";
  expect_found(*real(), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Of, AxesPermutations, testing::Values("acc", "gyr", "mag"),
                         [](const auto& sensor) { return std::string(sensor.param); });

// An odd number of inverted axes gives a fit with the dip's sign reversed.
TEST(AxesOfSensors, of_a_magnetometer_are_all_decided_where_the_hemisphere_is_known) {
  for (const Matrix3& Q : signed_permutations()) {
    SCOPED_TRACE(axes_text(Q));
    const double dip = Q.determinant();
    const Check check =
        check_axes(check_mounting(turned(simulated(), "mag", Q)), Matrix3::Identity(), dip, 1);
    const bool inverted = Q.determinant() < 0.0;
    EXPECT_THAT(check.sentence, Not(HasSubstr("no motion can tell")));
    EXPECT_EQ(check.status == CheckStatus::kBad, inverted) << check.sentence;
    if (inverted) {
      EXPECT_THAT(check.sentence, HasSubstr("--axes mag=" + axes_text(Q.transpose())));
    } else if (!Q.isIdentity()) {
      EXPECT_THAT(check.sentence, HasSubstr("sign of the dip at your place confirms"));
    }
  }
}

TEST(AxesOfSensors, are_not_judged_by_the_sign_of_a_flat_dip) {
  const Mounting m = check_mounting(simulated());
  EXPECT_EQ(check_axes(m, Matrix3::Identity(), -0.1, 1).status, CheckStatus::kOk);
  EXPECT_EQ(check_axes(m, Matrix3::Identity(), -0.3, 1).status, CheckStatus::kBad);
}

TEST(AxesOfSensors, all_three_in_different_directions_are_found_together) {
  const Matrix3 A = axes_from_text("y,-x,z"), M = axes_from_text("-z,y,x");
  Recording r = turned(simulated(), "acc", A);
  turn_axes(r, "mag", M);
  const Mounting m = check_mounting(r);
  ASSERT_EQ(m.findings.size(), 2u) << m.sentence;
  EXPECT_EQ(m.findings[0].remedy, A.transpose());
  EXPECT_EQ(m.findings[1].remedy, M.transpose());
}

TEST(AxesOfSensors, an_odd_gyroscope_is_found_though_the_magnetometer_is_turned_as_well) {
  Recording r = turned(simulated(), "gyr", axes_from_text("x,y,-z"));
  const Matrix3 M = axes_from_text("-x,-y,z");
  turn_axes(r, "mag", M);
  const Mounting m = check_mounting(r);
  ASSERT_EQ(m.findings.size(), 2u) << m.sentence;
  EXPECT_EQ(m.findings[0].sensor, "gyr");
  EXPECT_EQ(m.findings[0].remedy, axes_from_text("x,y,-z"));
  EXPECT_EQ(m.findings[1].remedy, M.transpose());
}

TEST(AxesOfSensors, the_remedy_makes_them_agree) {
  for (const char* sensor : {"acc", "gyr", "mag"}) {
    Recording r = turned(simulated(), sensor, axes_from_text("-z,x,-y"));
    for (const AxesFinding& f : check_mounting(r).findings) turn_axes(r, f.sensor, f.remedy);
    EXPECT_EQ(check_mounting(r).status, MountingStatus::kConsistent);
  }
}

TEST(AxesOfSensors, a_turn_about_one_axis_only_leaves_them_undecided_but_names_the_truth) {
  Recording r = simulated();
  // Turning about z alone: every direction is where a turn by the rate's integral takes it.
  Rot3 nRb;
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    const Vector3 omega(0.0, 0.0, 1.5 * std::sin(0.4 * r.gyr.t[k]));
    r.gyr.v[k] = omega;
    r.acc.v[k] = nRb.unrotate(Vector3(3.0, 2.0, 9.0)) + 1e-3 * simulated().gyr.v[k];
    r.mag[0].v[k] = nRb.unrotate(Vector3(20.0, 5.0, -40.0)) + 1e-3 * simulated().gyr.v[k];
    nRb = nRb * Rot3::Exp(omega / 50.0);
  }
  const Mounting m = check_mounting(r);
  EXPECT_EQ(m.status, MountingStatus::kUndecided);
  EXPECT_GT(m.fits[0].gyr_axes.size(), 1u);
  EXPECT_TRUE(m.fits[0].may_be_straight());
  EXPECT_THAT(m.sentence, HasSubstr("cannot be told"));
  EXPECT_THAT(m.sentence, HasSubstr("all three of its axes"));
}

TEST(AxesOfSensors, a_sensor_at_rest_leaves_them_undecided) {
  const Mounting m = check_mounting(slice(simulated(), 0.0, 2.5));
  EXPECT_EQ(m.status, MountingStatus::kUndecided);
  EXPECT_THAT(m.sentence, HasSubstr("hardly turned"));
}

TEST(AxesOfSensors, disagreement_is_part_of_the_verdict) {
  const Calibration imu = calibrate(turned(simulated(), "acc", axes_from_text("y,x,z")));
  EXPECT_EQ(imu.trust.verdict, Verdict::kNo);
  EXPECT_THAT(imu.trust.reasons, testing::Contains(HasSubstr("--axes acc=-y,-x,-z")));
  const Recording mag = turned(simulated(), "mag", axes_from_text("x,y,-z"));
  const Calibration c = calibrate(mag);
  EXPECT_EQ(c.trust.verdict, Verdict::kLimited);
  EXPECT_THAT(c.trust.reasons, testing::ElementsAre(HasSubstr("--axes mag=x,y,-z")));
  CalibrationOptions known;
  known.initialization.dip_rad = c.parameters.dip_rad;
  EXPECT_EQ(calibrate(mag, known).trust.verdict, Verdict::kYes);
}

}  // namespace
}  // namespace magimu
