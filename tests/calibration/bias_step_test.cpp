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

Simulation with_magnet(SimulatedMotion motion, std::uint64_t seed, const Vector3& by_uT,
                       double begin_s, double end_s = 1e9) {
  SimulationOptions options;
  options.rate_hz = 80.0;
  options.seed = seed;
  options.duration_s = 90.0;
  options.motion = motion;
  Simulation s = simulate(options);
  VectorSeries& mag = s.recording.mag[0];
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (mag.t[k] > begin_s && mag.t[k] < end_s) mag.v[k] += by_uT;
  }
  return s;
}

// Of the bias, from what it should be.
double largest_of_sigmas(const Calibration& c, const Vector3& bias) {
  const Vector3 sigma = c.covariance.diagonal().segment<3>(15).cwiseSqrt();
  return (c.parameters.mag[0].bias - bias).cwiseQuotient(sigma).cwiseAbs().maxCoeff();
}

TEST(BiasStep, leaves_the_calibration_that_holds_since_then) {
  const Vector3 by(0.4, -1.8, 1.1);
  for (const SimulatedMotion motion : {SimulatedMotion::kHand, SimulatedMotion::kHandHeld}) {
    const Simulation s = with_magnet(motion, 5501, by, 33.3);
    const Calibration c = calibrate(s.recording);
    EXPECT_EQ(c.trust.verdict, Verdict::kYes);
    ASSERT_FALSE(c.warnings.empty());
    EXPECT_THAT(c.warnings.front(), HasSubstr("bias changed for good"));
    EXPECT_LT(largest_of_sigmas(c, s.truth.parameters.mag[0].bias + by), 4.0);
    EXPECT_LT(c.covariance.diagonal().segment<3>(15).cwiseSqrt().maxCoeff(), 0.02);
    const Calibration whole = calibrate_whole({&s.recording});
    EXPECT_NE(whole.trust.verdict, Verdict::kYes);
    ASSERT_FALSE(whole.trust.reasons.empty());
    EXPECT_THAT(whole.trust.reasons.front(), HasSubstr("bias changed for good, by about"));
  }
}

// Its readings of that time are left out: a small one, and one so strong that the fit of all
// samples is worth nothing.
TEST(BiasStep, that_passes_leaves_the_calibration_outside_of_it) {
  for (const double size_uT : {3.0, 20.0}) {
    const Vector3 by = size_uT * Vector3(0.6, -0.64, 0.48);
    const Simulation s = with_magnet(SimulatedMotion::kHand, 5504, by, 30.0, 48.0);
    const Calibration c = calibrate(s.recording);
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << size_uT;
    ASSERT_FALSE(c.warnings.empty()) << size_uT;
    EXPECT_THAT(c.warnings.front(), HasSubstr("and gone then")) << size_uT;
    EXPECT_LT(largest_of_sigmas(c, s.truth.parameters.mag[0].bias), 4.0) << size_uT;
    EXPECT_LT(c.covariance.diagonal().segment<3>(15).cwiseSqrt().maxCoeff(), 0.02) << size_uT;
    EXPECT_NE(calibrate_whole({&s.recording}).trust.verdict, Verdict::kYes) << size_uT;
  }
}

TEST(BiasStep, may_be_two) {
  Simulation s = with_magnet(SimulatedMotion::kHand, 5505, Vector3(4.0, 1.0, -2.0), 20.0);
  const Vector3 more(-2.0, 2.0, 3.0);
  VectorSeries& mag = s.recording.mag[0];
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (mag.t[k] > 45.0) mag.v[k] += more;
  }
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
  const Vector3 last = s.truth.parameters.mag[0].bias + Vector3(4.0, 1.0, -2.0) + more;
  EXPECT_LT(largest_of_sigmas(c, last), 4.0);
}

// What follows is too little.
TEST(BiasStep, near_the_end_is_the_first_reason) {
  const Simulation s = with_magnet(SimulatedMotion::kHand, 5502, Vector3(3.0, 0.0, -1.0), 80.0);
  const Calibration c = calibrate(s.recording);
  EXPECT_NE(c.trust.verdict, Verdict::kYes);
  ASSERT_FALSE(c.trust.reasons.empty());
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("a magnet or iron was attached or removed"));
}

TEST(BiasStep, is_none_where_nothing_changes) {
  const Simulation s = with_magnet(SimulatedMotion::kHand, 5503, Vector3::Zero(), 40.0);
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
  EXPECT_TRUE(c.warnings.empty());
  EXPECT_EQ(c.samples, int(s.recording.gyr.size()));
}

}  // namespace
}  // namespace magimu
