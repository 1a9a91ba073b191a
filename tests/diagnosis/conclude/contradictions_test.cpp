// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/contradictions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "tests/diagnosis/example_diagnosis.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

Finding change_from(double t0, double t1, double sigma) {
  Finding f;
  f.effect = "mag_change";
  f.channel = "mag";
  f.parameters = {{"k[0]", 0.01, 0.001, "1"}, {"t0", t0, sigma, "s"}, {"t1", t1, sigma, "s"}};
  return f;
}

Recording turned() {
  oracle::Options o;
  o.seed = 3;
  o.motion.duration_s = 30.0;
  return oracle::simulate(o).recording;
}

TEST(Contradictions, what_ends_before_its_begin_is_known_did_not_change) {
  const Recording r = turned();
  Diagnosis d;
  d.findings = {change_from(12.0, 14.7, 1.9)};
  withdraw_contradicted({&r}, d);
  EXPECT_THAT(d.findings, IsEmpty());
  ASSERT_EQ(d.structure.evidence.size(), 1u);
  EXPECT_THAT(d.structure.evidence[0], HasSubstr("About 13.3 s, for some 2.7 s, the magnetometer"));
}

TEST(Contradictions, a_change_of_known_times_stays) {
  const Recording r = turned();
  Diagnosis d;
  d.findings = {change_from(12.0, 14.7, 0.1),
                change_from(12.0, std::numeric_limits<double>::infinity(), 1.9)};
  withdraw_contradicted({&r}, d);
  EXPECT_EQ(d.findings.size(), 2u);
  EXPECT_FALSE(d.structure.detected);
}

TEST(Contradictions, nothing_is_named_of_rows_of_two_devices) {
  Recording r = turned();
  VectorSeries& mag = r.mag.front();
  for (std::size_t k = 0; k < mag.size(); k += 3) mag.v[k] = 1.1 * mag.v[k] + Vector3(5, -4, 3);
  Finding motion;
  motion.effect = "linear_acceleration";
  motion.channel = "acc";
  Diagnosis d;
  d.findings = {motion, change_from(12.0, 20.0, 0.1)};
  withdraw_contradicted({&r}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "linear_acceleration");
  ASSERT_EQ(d.structure.evidence.size(), 1u);
  EXPECT_THAT(d.structure.evidence[0], HasSubstr("Every third sample of mag stands out"));
}

// Gains that change alike, and a bias that changes by s.
Diagnosis change_of_gains(const Vector3& k, const Vector3& s) {
  Diagnosis d;
  d.after = test::example_calibration(0.0);  // bias 12, -5, 3 uT
  Finding f;
  f.effect = "mag_change";
  f.channel = "mag";
  for (int i = 0; i < 3; ++i)
    f.parameters.push_back({fmt::format("effects.mag_change.k[{}]", i), k[i], 3e-4, "1"});
  for (int i = 0; i < 3; ++i)
    f.parameters.push_back({fmt::format("effects.mag_change.s[{}]", i), s[i], 0.01, "uT"});
  f.parameters.push_back({"t0", 71.6, 0.1, "s"});
  f.sentence = "As it was.";
  d.findings = {f};
  reword_by_what_is_known({}, d);
  return d;
}

TEST(Contradictions, gains_that_change_alike_beside_a_bias_that_stays_are_the_field) {
  const Vector3 k = Vector3::Constant(0.06);
  EXPECT_THAT(change_of_gains(k, {-0.72, 0.3, -0.18}).findings[0].sentence,
              testing::AllOf(HasSubstr("The strength of the field was another from 71.60 s"),
                             HasSubstr("(2.88 uT)")));
  EXPECT_EQ(change_of_gains(k, {0.0, 0.0, 0.0}).findings[0].sentence, "As it was.")
      << "with its bias: the sensor's gains";
  EXPECT_EQ(change_of_gains({0.06, 0.06, 0.05}, {-0.72, 0.3, -0.15}).findings[0].sentence,
            "As it was.");
}

TEST(Contradictions, a_dead_band_is_named_and_not_what_it_imitates) {
  Recording r = turned();
  for (Vector3& v : r.gyr.v) {
    for (double& x : v) x = std::abs(x) < 0.1 ? 0.0 : x;
  }
  Finding bias;
  bias.effect = "gyro_bias_change";
  bias.channel = "gyr";
  Diagnosis d;
  d.findings = {bias};
  name_dead_band({&r}, d);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings[0].effect, "gyro_dead_band");
  EXPECT_NEAR(d.findings[0].parameters[0].value, 0.1, 0.02);
  EXPECT_THAT(d.findings[0].sentence, HasSubstr("it does not hang"));
  const Recording whole = turned();
  d.findings = {bias};
  name_dead_band({&whole}, d);
  EXPECT_EQ(d.findings[0].effect, "gyro_bias_change");
}

}  // namespace
}  // namespace magimu
