// SPDX-License-Identifier: BSD-3-Clause
// A calibration against the Earth's field at its place.
#include "calibration/trust/field_check.h"

#include <gmock/gmock.h>

#include "calibration/calibrate.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const EarthField kBerlin = earth_field({52.5, 13.4, 0.0, 2026.0});

Calibration with_field(double strength_uT, double dip_rad) {
  Calibration c;
  c.strength_uT = strength_uT;
  c.parameters.dip_rad = dip_rad;
  c.fields = {{"rec.csv", dip_rad, 0.005, 0.002}};
  return c;
}

Calibration checked(double strength_share, double dip_rad, const KnownField& known) {
  Calibration c = with_field(strength_share * kBerlin.strength_uT, dip_rad);
  check_field(c, known);
  return c;
}

TEST(FieldCheck, is_content_with_the_field_of_the_place) {
  const Calibration c = checked(1.02, kBerlin.dip_rad + 0.02, {kBerlin, {}});
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
  ASSERT_EQ(c.checks.size(), 1u);
  EXPECT_EQ(c.checks[0].name, "location");
  EXPECT_EQ(c.checks[0].status, CheckStatus::kOk);
  EXPECT_NEAR(c.checks[0].value, 0.02 / kDegree, 1e-9);
}

TEST(FieldCheck, finds_an_odd_number_of_inverted_axes) {
  const Calibration c = checked(1.0, -kBerlin.dip_rad, {kBerlin, {}});
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("an odd number of axes is inverted"));
  const Calibration south = checked(1.0, kBerlin.dip_rad, {{}, Hemisphere::kSouth});
  EXPECT_EQ(south.trust.verdict, Verdict::kNo);
  EXPECT_EQ(checked(1.0, kBerlin.dip_rad, {{}, Hemisphere::kNorth}).trust.verdict, Verdict::kYes);
}

TEST(FieldCheck, does_not_judge_the_sign_of_a_flat_dip) {
  const Calibration c = checked(1.0, 0.1, {{}, Hemisphere::kSouth});
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
  EXPECT_THAT(c.checks[0].sentence, HasSubstr("too flat"));
}

TEST(FieldCheck, names_the_unit_of_a_wrong_strength) {
  const std::pair<double, const char*> units[] = {
      {1e-6, "tesla"}, {1e-2, "gauss"}, {10.0, "milligauss"}, {1e3, "nT"}};
  for (const auto& [ratio, unit] : units) {
    const Calibration c = checked(1.1 * ratio, kBerlin.dip_rad, {kBerlin, {}});
    EXPECT_EQ(c.trust.verdict, Verdict::kLimited);
    EXPECT_THAT(c.trust.reasons.front(), HasSubstr(std::string(" in ") + unit + ", not in uT"));
  }
}

TEST(FieldCheck, suspects_iron) {
  EXPECT_EQ(checked(0.9, kBerlin.dip_rad, {kBerlin, {}}).checks[0].status, CheckStatus::kCaution);
  const Calibration strength = checked(0.7, kBerlin.dip_rad, {kBerlin, {}});
  EXPECT_THAT(strength.trust.reasons.front(), AllOf(HasSubstr("iron"), HasSubstr("in the open")));
  const Calibration dip = checked(1.0, kBerlin.dip_rad - 0.2, {kBerlin, {}});
  EXPECT_EQ(dip.trust.verdict, Verdict::kLimited);
  EXPECT_THAT(dip.trust.reasons.front(), HasSubstr("bends the field"));
}

TEST(FieldPrior, pulls_strength_and_dip_as_far_as_it_is_sure) {
  const Simulation s = test::simulated_hand(50.0, 4, 40.0);
  CalibrationOptions options = test::same_model_and_noise(s);
  const Calibration plain = calibrate(s.recording, options);
  EarthField field;
  field.strength_uT = s.truth.strength_uT;
  field.dip_rad = s.truth.parameters.dip_rad;
  options.also = field_prior(field, 1, {.strength_sigma_uT = 1e-4, .dip_sigma_rad = 1e-5});
  const Calibration sure = calibrate(s.recording, options);
  EXPECT_NEAR(sure.strength_uT, field.strength_uT, 5e-4);
  EXPECT_NEAR(sure.parameters.dip_rad, field.dip_rad, 5e-5);
  EXPECT_LT(sure.sigma_model("field.dip_deg"), plain.sigma_model("field.dip_deg"));
  options.also = field_prior(field, 1, {.strength_sigma_uT = 1e3, .dip_sigma_rad = 1e3});
  EXPECT_LT(test::sigmas_apart(calibrate(s.recording, options), plain), 1e-3);
}

TEST(InvertedAxes, fit_as_well_and_are_found_by_the_hemisphere) {
  SimulationOptions simulation;
  simulation.motion = SimulatedMotion::kHand;
  simulation.rate_hz = 50.0;
  simulation.duration_s = 40.0;
  Simulation s = simulate(simulation);
  const Hemisphere true_one =
      s.truth.parameters.dip_rad > 0.0 ? Hemisphere::kNorth : Hemisphere::kSouth;
  Calibration right = calibrate(s.recording, test::same_model_and_noise(s));
  for (Vector3& v : s.recording.mag[0].v) v[1] = -v[1];
  Calibration inverted = calibrate(s.recording, test::same_model_and_noise(s));
  EXPECT_NEAR(inverted.fit.cost_final / right.fit.cost_final, 1.0, 1e-6);
  EXPECT_NEAR(inverted.parameters.dip_rad, -right.parameters.dip_rad, 1e-3);
  check_field(right, {{}, true_one});
  check_field(inverted, {{}, true_one});
  EXPECT_NE(right.trust.verdict, Verdict::kNo);
  EXPECT_EQ(inverted.trust.verdict, Verdict::kNo);
}

}  // namespace
}  // namespace magimu
