// SPDX-License-Identifier: BSD-3-Clause
// What changes in mid-recording is not taken for what is the same throughout.
#include "tests/calibration/face_placing.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "calibration/calibrate_whole.h"

namespace magimu {
namespace {

TEST(FacePlacing, is_calibrated_where_nothing_changes) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    const test::FacePlacing faces;
    const Calibration c = calibrate(test::recording_of(faces, seed));
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
    const Vector3 error = c.parameters.mag.front().bias - faces.mag_bias;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(error[axis]), 5.0 * std::sqrt(c.covariance(15 + axis, 15 + axis)));
    }
  }
}

// No calibration is right before and after a magnet is put on: the sigmas of one of all samples
// contain both, and the one that is given holds since then.
TEST(FacePlacing, with_a_magnet_put_on_is_not_believed) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    test::FacePlacing faces;
    faces.mag_step = Vector3(0.5, 3.0, -1.0);
    const Recording recording = test::recording_of(faces, seed);
    const Calibration c = calibrate_whole({&recording});
    EXPECT_NE(c.trust.verdict, Verdict::kYes);
    const Calibration since = calibrate(recording);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(since.parameters.mag.front().bias[axis] - faces.mag_bias[axis] -
                         faces.mag_step[axis]),
                4.0 * std::sqrt(since.covariance(15 + axis, 15 + axis)));
    }
    for (const Vector3& truth : {faces.mag_bias, Vector3(faces.mag_bias + faces.mag_step)}) {
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LT(std::abs(c.parameters.mag.front().bias[axis] - truth[axis]),
                  3.0 * std::sqrt(c.covariance(15 + axis, 15 + axis)));
      }
    }
  }
}

// Each attitude is taken once or twice, so that nine numbers of a g-sensitivity explain two biases.
TEST(FacePlacing, two_biases_of_the_gyroscope_are_no_sensitivity_to_gravity) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    test::FacePlacing faces;
    faces.gyr_step = Vector3(0.0053, -0.0028, -0.0005);
    const Calibration c = calibrate(test::recording_of(faces, seed));
    EXPECT_EQ(std::ranges::count(c.effects, "gyro_g_sensitivity", &ActiveEffect::name), 0);
    for (const Vector3& truth : {faces.gyr_bias, Vector3(faces.gyr_bias + faces.gyr_step)}) {
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LT(std::abs(c.parameters.gyr_bias[axis] - truth[axis]),
                  3.0 * std::sqrt(c.covariance(3 + axis, 3 + axis)));
      }
    }
  }
}

}  // namespace
}  // namespace magimu
