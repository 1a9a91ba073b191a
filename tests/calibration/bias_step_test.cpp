// SPDX-License-Identifier: BSD-3-Clause
// A magnet that is attached to the device while it is turned: the calibration is the one that holds
// since then, where what follows tells it; where it is too little, the first reason says what
// happened.
#include "tests/calibration/cases.h"

#include <gmock/gmock.h>

#include "calibration/calibrate_whole.h"

namespace magimu {
namespace {

using testing::HasSubstr;

Simulation with_magnet(SimulatedMotion motion, std::uint64_t seed, double at_s,
                       const Vector3& by_uT) {
  SimulationOptions options;
  options.rate_hz = 80.0;
  options.seed = seed;
  options.duration_s = 90.0;
  options.motion = motion;
  Simulation s = simulate(options);
  VectorSeries& mag = s.recording.mag[0];
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (mag.t[k] > at_s) mag.v[k] += by_uT;
  }
  return s;
}

TEST(BiasStep, leaves_the_calibration_that_holds_since_then) {
  const Vector3 by(0.4, -1.8, 1.1);
  for (const SimulatedMotion motion : {SimulatedMotion::kHand, SimulatedMotion::kHandHeld}) {
    const Simulation s = with_magnet(motion, 5501, 33.3, by);
    const Calibration c = calibrate(s.recording);
    EXPECT_EQ(c.trust.verdict, Verdict::kYes);
    ASSERT_FALSE(c.warnings.empty());
    EXPECT_THAT(c.warnings.front(), HasSubstr("bias changed for good"));
    const Vector3 e = c.parameters.mag[0].bias - s.truth.parameters.mag[0].bias - by;
    EXPECT_LT(e.norm(), 0.05);
    const Vector3 sigma = c.covariance.diagonal().segment<3>(15).cwiseSqrt();
    EXPECT_LT(e.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 4.0);
    const Calibration whole = calibrate_whole({&s.recording});
    EXPECT_NE(whole.trust.verdict, Verdict::kYes);
    ASSERT_FALSE(whole.trust.reasons.empty());
    EXPECT_THAT(whole.trust.reasons.front(), HasSubstr("bias changed for good, by about"));
  }
}

// What follows is too little.
TEST(BiasStep, near_the_end_is_the_first_reason) {
  const Simulation s = with_magnet(SimulatedMotion::kHand, 5502, 80.0, Vector3(3.0, 0.0, -1.0));
  const Calibration c = calibrate(s.recording);
  EXPECT_NE(c.trust.verdict, Verdict::kYes);
  ASSERT_FALSE(c.trust.reasons.empty());
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("a magnet or iron was attached or removed"));
}

TEST(BiasStep, is_none_where_nothing_changes) {
  const Simulation s = with_magnet(SimulatedMotion::kHand, 5503, 40.0, Vector3::Zero());
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
  EXPECT_TRUE(c.warnings.empty());
  EXPECT_EQ(c.samples, int(s.recording.gyr.size()));
}

}  // namespace
}  // namespace magimu
