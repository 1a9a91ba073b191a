// SPDX-License-Identifier: BSD-3-Clause
// What pages say in words people know: parameters' names, before and after, where a result comes
// from; and the page of `magimu info --report`.
#include <gmock/gmock.h>

#include "apps/page/report.h"
#include "apps/page/report_field_gain.h"
#include "apps/page/report_provenance.h"
#include "apps/say/calibration_table.h"
#include "apps/say/parameter_words.h"
#include "calibration/calibrate.h"
#include "sim/simulate.h"
#include "tests/apps/program.h"
#include "tests/apps/well_formed.h"
#include "tests/diagnosis/example_diagnosis.h"

namespace magimu::apps {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

TEST(ParameterWords, name_axes_and_keep_the_symbol) {
  EXPECT_EQ(parameter_words("hard_iron_change", "s[0]"), "change of the bias, x (s[0])");
  EXPECT_EQ(parameter_words("hard_iron_change", "t1"), "until (t1)");
  EXPECT_EQ(parameter_words("mag_change", "C[0][1]"), "change, x by y (C[0][1])");
  EXPECT_EQ(parameter_words("acc_change", "k[2]"), "change of the gain, z (k[2])");
  EXPECT_EQ(parameter_words("mag_own_clock", "T"), "period, or an alias of it (T)");
  EXPECT_EQ(parameter_words("hard_iron_drift", "c[1][2]"),
            "drift of the bias, linear, z (c[1][2])");
  EXPECT_EQ(parameter_words("acc_gain_drift", "k[0][1]"),
            "drift of the gain, its mean, y (k[0][1])");
  EXPECT_EQ(parameter_words("gyro_scale_misalignment", "S[1][1]"), "scale of y (S[1][1])");
  EXPECT_EQ(parameter_words("acc_scale_misalignment", "L[2][0]"),
            "misalignment, x into z (L[2][0])");
  EXPECT_EQ(parameter_words("mains_interference", "a_y"), "amplitude, in phase, y (a_y)");
  EXPECT_EQ(parameter_words("mag_lag", "tau"), "lag (tau)");
}

TEST(ParameterWords, leave_what_they_do_not_know) {
  EXPECT_EQ(parameter_words("a_new_effect", "u[2]"), "u[2]");
  EXPECT_EQ(parameter_words("mag_lag", ""), "");
}

TEST(ParameterWords, of_a_calibration_have_the_sensors_name_and_the_unit) {
  EXPECT_EQ(calibration_parameter_words("magnetometers[1].distortion[0][2]", {"a", "b"}),
            "b distortion D xz");
  EXPECT_EQ(calibration_parameter_words("gyroscope.scale_misalignment[1][0]", {"mag"}),
            "gyroscope scale, misalignment S yx");
  EXPECT_EQ(calibration_parameter_unit("gyroscope.scale_misalignment[1][0]"), "");
  EXPECT_EQ(calibration_parameter_unit("magnetometers[0].time_offset_s"), "s");
}

TEST(CalibrationTable, tells_how_to_use_it_only_where_it_may_be_used) {
  Calibration c = test::example_calibration(0.0);
  c.trust.verdict = Verdict::kYes;
  EXPECT_THAT(calibration_table(c), HasSubstr("To use it:"));
  c.trust.verdict = Verdict::kNo;
  EXPECT_THAT(calibration_table(c), Not(HasSubstr("To use it:")));
}

TEST(CalibrationTable, says_why_a_hand_leaves_small_residuals) {
  Calibration c = test::example_calibration(0.0);
  EXPECT_THAT(calibration_table(c), Not(HasSubstr("trajectory follows")));
  c.motion = MotionModel::kHandHeld;
  EXPECT_THAT(calibration_table(c), HasSubstr("trajectory follows accelerometer and gyroscope"));
}

TEST(CalibrationTable, says_in_words_what_was_known_before) {
  Calibration c = test::example_calibration(0.0);
  c.prior.source = "default";
  for (int j = 0; j < 3; ++j) {
    c.prior.parameters.push_back(
        {"magnetometers[0].distortion[0][" + std::to_string(j) + "]", 48.0, 1.0, 30.0, 1.0});
  }
  c.prior.parameters.push_back({"accelerometer.bias[0]", 0.0, 0.2, 2.5, 0.1});
  c.prior.parameters.push_back({"field.dip_deg", 0.0, 2.0, 2e3, 1.0});
  EXPECT_THAT(calibration_table(c),
              AllOf(HasSubstr("tells nothing of mag distortion D xx xy xz:"),
                    HasSubstr("accelerometer bias o_a x (by itself known to 2.5 m/s^2)"),
                    HasSubstr("dip (by itself not known)")));
}

TEST(AxesAsLetters, turn_indices_of_vectors_and_matrices_into_letters) {
  EXPECT_EQ(axes_as_letters("gyroscope bias o_w[1]"), "gyroscope bias o_w y");
  EXPECT_EQ(axes_as_letters("mag distortion D[2][0]"), "mag distortion D zx");
  EXPECT_EQ(axes_as_letters("fields[12] dip"), "fields[12] dip");
}

TEST(FieldGain, has_length_and_heading_before_and_after) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.duration_s = 60.0;
  options.gravity = kStandardGravity;
  Simulation s = simulate(options);
  // The readings that a perfect sensor gives, 10 uT off along x.
  const SensorParameters& truth = s.truth.parameters;
  const double strength = s.truth.strength_uT;
  for (Vector3& v : s.recording.mag[0].v) {
    v = strength * (truth.mag[0].distortion.inverse() * (v - truth.mag[0].bias)) +
        10.0 * Vector3::UnitX();
  }
  const Calibration c = calibrate(s.recording);
  const FieldGain gain = field_gain(c, {&s.recording}, 0);
  // The length varies by 10 uT times the cosine to x, over all directions: 10 / sqrt(3) RMS.
  EXPECT_NEAR(gain.length_before, 10.0 / strength / std::sqrt(3.0), 0.35 * gain.length_before);
  EXPECT_LT(gain.length_after, 0.02);
  // Steep dips make headings worse; corrected, they are those of the motion but for noise.
  EXPECT_GT(gain.heading_before_deg, 10.0);
  EXPECT_LT(gain.heading_after_deg, 0.1 * gain.heading_before_deg);
}

TEST(Page, ends_with_version_command_and_date) {
  const std::string page = Page("a title").finish();
  EXPECT_EQ(test::xml_error(page), "");
  EXPECT_THAT(page, HasSubstr("Made by magimu " + provenance().version));
  EXPECT_THAT(provenance().date, MatchesRegex("20..-..-..T..:..:..Z"));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme: dark"));
}

TEST(Provenance, quotes_words_as_a_shell_takes_them) {
  const char* const words[] = {"/usr/bin/magimu", "calibrate", "my file.csv", "--unit=mag=nT",
                               "it's"};
  remember_command(5, words);
  EXPECT_EQ(provenance().command, "magimu calibrate 'my file.csv' --unit=mag=nT 'it'\\''s'");
  EXPECT_EQ(provenance_json({"my file.csv"})["files"][0], "my file.csv");
  remember_command(0, nullptr);
}

class InfoReport : public testing::Test {
 protected:
  test::Program magimu_;
};

TEST_F(InfoReport, is_a_page_of_its_own_with_faults_and_remedies) {
  ASSERT_EQ(magimu_("simulate -q -o rec.csv --motion hand --rate 50 --duration 60").exit_code,
            kDone);
  ASSERT_EQ(magimu_("info -q rec.csv --report look.html").exit_code, kDone);
  const std::string page = magimu_.text("look.html");
  EXPECT_EQ(test::xml_error(page), "");
  EXPECT_THAT(page, HasSubstr("It can be calibrated."));
  EXPECT_THAT(page, HasSubstr("magimu info -q rec.csv --report look.html"));
  EXPECT_THAT(page, HasSubstr(">mag distortion D zx<"));
  EXPECT_THAT(page, testing::Not(HasSubstr("magnetometers x")));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
}

TEST_F(InfoReport, is_written_for_a_recording_that_cannot_be_calibrated) {
  // Degrees a second that pass for radians.
  ASSERT_EQ(magimu_("simulate -q -o rec.csv --motion hand --rate 50 --duration 60 --effect "
                    "gyro_scale_misalignment=56.3:0:0:0:56.3:0:0:0:56.3")
                .exit_code,
            kDone);
  EXPECT_EQ(magimu_("info -q rec.csv --report look.html").exit_code, kNoAnswer);
  const std::string page = magimu_.text("look.html");
  EXPECT_EQ(test::xml_error(page), "");
  EXPECT_THAT(page, HasSubstr("cannot be calibrated as it is"));
  EXPECT_THAT(page, HasSubstr("status bad"));
}

TEST_F(InfoReport, does_not_overwrite_the_recording) {
  ASSERT_EQ(magimu_("simulate -q -o rec.csv --motion hand --rate 50 --duration 20").exit_code,
            kDone);
  EXPECT_EQ(magimu_("info -q rec.csv --report rec.csv").exit_code, kUnusable);
}

}  // namespace
}  // namespace magimu::apps
