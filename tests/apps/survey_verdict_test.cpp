// SPDX-License-Identifier: BSD-3-Clause
// The last line of `magimu info`.
#include <gmock/gmock.h>

#include "apps/say/survey_report.h"
#include "recording/data/axes.h"

namespace magimu::apps {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// Turned enough; `ways` of the axes fit what the accelerometer reads.
Survey turned(const std::vector<Matrix3>& ways) {
  Survey s;
  s.turned.enough = true;
  s.coverage.up = 0.5;
  s.strength_uT = 50.0;
  s.ellipsoid_rms_uT = 0.3;
  s.mounting.status = ways.size() == 1 ? MountingStatus::kConsistent : MountingStatus::kUndecided;
  s.mounting.fits = {{"acc", ways, 0.01, 0.01}};
  return s;
}

TEST(SurveyVerdict, axes_that_may_be_right_leave_nothing_open) {
  const std::vector<Matrix3> all = signed_permutations();
  EXPECT_EQ(survey_verdict(turned({all[0]})), "It can be calibrated.");
  EXPECT_THAT(survey_verdict(turned({all[3], all[0]})),
              StartsWith("It can be calibrated if the sensors' axes agree"));
  EXPECT_THAT(survey_verdict(turned({all[3], all[7]})), HasSubstr("is open"));
}

TEST(SurveyVerdict, a_small_motion_is_no_disturbance) {
  Survey s = turned(signed_permutations());
  s.ellipsoid_rms_uT = 4.0;
  EXPECT_THAT(survey_verdict(s), HasSubstr("the field was disturbed"));
  s.coverage.up = 0.09;
  EXPECT_THAT(survey_verdict(s), HasSubstr("up pointed to 9 %"));
}

}  // namespace
}  // namespace magimu::apps
