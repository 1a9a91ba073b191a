// SPDX-License-Identifier: BSD-3-Clause
// Real hands (BROAD): no truth for the parameters, but the fit has to end, and a model that does
// not hold has to be noticed.
#include <gmock/gmock.h>

#include <filesystem>

#include "calibration/calibrate_whole.h"
#include "recording/read.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

class RealRecording : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(MAGIMU_DATA_DIR) / "broad" / GetParam();
    if (!std::filesystem::exists(path_)) {
      GTEST_SKIP() << "This test needs the BROAD recording " << GetParam()
                   << ", which is not part of the project.";
    }
  }
  std::filesystem::path path_;
};

TEST_P(RealRecording, converges) {
  const Calibration c = calibrate(read_recording(path_.string()));
  EXPECT_TRUE(c.fit.converged()) << c.fit.message;
  EXPECT_TRUE(in_calibration_order(c).allFinite());
  EXPECT_TRUE(c.covariance.allFinite());
  EXPECT_FALSE(c.trust.verdict != Verdict::kYes && c.trust.reasons.empty());
}

std::string name_of_file(const testing::TestParamInfo<const char*>& info) {
  return "broad_" + std::string(info.param).substr(0, 2);
}

INSTANTIATE_TEST_SUITE_P(
    Broad, RealRecording,
    testing::Values("02_undisturbed_slow_rotation_B.hdf5", "03_undisturbed_slow_rotation_C.hdf5",
                    "07_undisturbed_fast_rotation_B.hdf5", "11_undisturbed_slow_translation_B.hdf5",
                    "21_undisturbed_fast_combined.mat", "24_disturbed_tapping_A.hdf5",
                    "29_disturbed_stationary_magnet_B.mat",
                    "33_disturbed_attached_magnet_2cm.hdf5"),
    name_of_file);

class MovedSensor : public RealRecording {};

TEST_P(MovedSensor, the_rotation_model_says_that_it_does_not_hold) {
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;
  const Calibration c = calibrate(read_recording(path_.string()), options);
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  EXPECT_THAT(c.trust.reasons, testing::Contains(testing::HasSubstr("hand moved the sensor")));
}

class AttachedMagnet : public RealRecording {};

TEST_P(AttachedMagnet, the_moment_of_its_removal_is_told) {
  const Recording recording = read_recording(path_.string());
  const Calibration whole = calibrate_whole({&recording});
  EXPECT_NE(whole.trust.verdict, Verdict::kYes);
  EXPECT_THAT(whole.trust.reasons,
              testing::Contains(testing::ContainsRegex("for good at about 9[89]")));
  const Calibration outside = calibrate(recording);
  EXPECT_NE(outside.trust.verdict, Verdict::kNo);
  EXPECT_THAT(outside.warnings, testing::Contains(testing::ContainsRegex(
                                    "Between about 4[0-4] and (9[5-9]|10[0-4]) s .*another one")));
}

INSTANTIATE_TEST_SUITE_P(Broad, AttachedMagnet,
                         testing::Values("33_disturbed_attached_magnet_2cm.hdf5"), name_of_file);

INSTANTIATE_TEST_SUITE_P(Broad, MovedSensor,
                         testing::Values("11_undisturbed_slow_translation_B.hdf5",
                                         "21_undisturbed_fast_combined.mat"),
                         name_of_file);

}  // namespace
}  // namespace magimu
