// SPDX-License-Identifier: BSD-3-Clause
// A sensor that lies on a table: there is nothing to calibrate, and no cause is to be found in its
// noise.
#include <gmock/gmock.h>

#include "calibration/survey/survey.h"
#include "diagnosis/result/diagnosis.h"
#include "sim/draws/random.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

class LyingStill : public testing::TestWithParam<std::uint64_t> {
 protected:
  static constexpr double kRate = 20.0;  // Hz

  static Recording lying(double mag_density) {
    const SensorParameters p = draw_parameters(GetParam(), 1);
    RandomStream random(GetParam(), RandomPurpose::kMotion);
    const Rot3 nRb = Rot3::Exp(random.normal3());
    const double s = std::sqrt(kRate);
    Recording r;
    r.name = "still.csv";
    r.mag.resize(1);
    r.mag_names = {"mag"};
    for (int k = 0; k < int(60.0 * kRate); ++k) {
      const double t = k / kRate;
      r.gyr.push_back(t, p.gyr_bias + s * kPaperNoise.gyr * random.normal3());
      r.acc.push_back(t, accelerometer_model(nRb, p.acc_bias, gravity_n(kStandardGravity)) +
                             s * kPaperNoise.acc * random.normal3());
      r.mag[0].push_back(t, magnetometer_model(nRb, p.mag[0].distortion, p.mag[0].bias, p.dip_rad) +
                                s * mag_density * random.normal3());
    }
    return r;
  }
};

TEST_P(LyingStill, is_no_turning) {
  const Recording r = lying(kPaperNoise.mag);
  const Survey s = survey(r);
  EXPECT_FALSE(s.usable());
  EXPECT_FALSE(s.turned.only);
  // Per second: the gyroscope reads 0.9 deg/s of noise.
  EXPECT_LT(s.coverage.fastest_rad_s, 2.0 * kDegree);
}

TEST_P(LyingStill, has_no_cause) {
  for (const double density : {kPaperNoise.mag, 0.003}) {
    const Diagnosis d = diagnose(lying(density), {});
    EXPECT_EQ(d.answer, Answer::kNone);
    EXPECT_THAT(d.findings, testing::IsEmpty()) << d.findings.front().effect;
    EXPECT_EQ(d.before.trust.verdict, Verdict::kNo);
    EXPECT_GT(d.before.parameters.mag[0].distortion.determinant(), 0.0);
    EXPECT_GT(d.before.strength_uT, 0.0);
    EXPECT_THAT(d.before.trust.reasons.front(), testing::HasSubstr("The sensor hardly turned"));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, LyingStill, testing::Values(1, 3));

}  // namespace
}  // namespace magimu
