// SPDX-License-Identifier: BSD-3-Clause
// Recordings that do not permit a calibration: said in words, never in nonsense.
#include <gmock/gmock.h>

#include "calibration/calibrate_whole.h"
#include "calibration/result/calibration_json.h"
#include "calibration/trust/trust.h"
#include "recording/data/error.h"
#include "sim/draws/random.h"
#include "tests/calibration/cases.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A device with the paper's noise that turns at a constant rate in its own frame.
Recording turning(const Vector3& rate, double duration_s) {
  constexpr double kRate = 50.0;
  const SensorParameters p = draw_parameters(1, 1);
  RandomStream random(1, RandomPurpose::kMotion);
  Recording r;
  r.name = "turning.csv";
  r.mag.resize(1);
  r.mag_names = {"mag"};
  for (int k = 0; k < int(duration_s * kRate); ++k) {
    const double t = k / kRate, s = std::sqrt(kRate);
    const Rot3 nRb = Rot3::Exp(rate * t);
    r.gyr.push_back(t, rate + p.gyr_bias + s * kPaperNoise.gyr * random.normal3());
    r.acc.push_back(t, accelerometer_model(nRb, p.acc_bias, gravity_n(kStandardGravity)) +
                           s * kPaperNoise.acc * random.normal3());
    r.mag[0].push_back(t, magnetometer_model(nRb, p.mag[0].distortion, p.mag[0].bias, p.dip_rad) +
                              s * kPaperNoise.mag * random.normal3());
  }
  return r;
}

// JSON has no word for NaN: the library writes null.
void expect_no_null(const nlohmann::ordered_json& json, const std::string& where = "") {
  if (json.is_structured()) {
    for (const auto& [key, value] : json.items()) expect_no_null(value, where + "/" + key);
    return;
  }
  EXPECT_FALSE(json.is_null()) << where;
}

void expect_refused(const Calibration& c) {
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  ASSERT_FALSE(c.trust.reasons.empty());
  EXPECT_THAT(c.trust.reasons.front(),
              testing::ContainsRegex("Turn (it|the sensor) about all three"))
      << "says what to do";
  expect_no_null(to_json(c));
}

class TooLittleMotion : public testing::TestWithParam<MotionModel> {};

TEST_P(TooLittleMotion, turning_about_the_vertical_only_is_refused) {
  CalibrationOptions options;
  options.motion = GetParam();
  const Calibration c = calibrate(turning(Vector3(0, 0, 0.5), 60.0), options);
  expect_refused(c);
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("about one axis at the most"));
}

TEST_P(TooLittleMotion, turning_about_a_level_axis_only_is_refused) {
  CalibrationOptions options;
  options.motion = GetParam();
  expect_refused(calibrate(turning(Vector3(0.5, 0, 0), 60.0), options));
}

TEST_P(TooLittleMotion, lying_still_is_refused) {
  CalibrationOptions options;
  options.motion = GetParam();
  const Calibration c = calibrate(turning(Vector3::Zero(), 60.0), options);
  expect_refused(c);
  EXPECT_THAT(c.trust.reasons.front(),
              testing::AnyOf(HasSubstr("hardly turned"), HasSubstr("one axis at the most")));
}

INSTANTIATE_TEST_SUITE_P(Models, TooLittleMotion,
                         testing::Values(MotionModel::kRotation, MotionModel::kAuto),
                         [](const auto& test) { return to_string(test.param); });

Calibration with_acc_bias(const Vector3& bias) {
  Simulation s = test::simulated_hand(50.0, 3, 60.0);
  for (Vector3& a : s.recording.acc.v) a += bias;
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;
  return calibrate(s.recording, options);
}

// Of the MPU-9250 60 mg on x and y and 80 mg on z are in order, of the LSM9DS1 90 mg on each.
TEST(Verdict, a_bias_that_data_sheets_allow_on_every_axis_is_no_reason_against_a_calibration) {
  const Calibration c = with_acc_bias(Vector3(0.8, -0.8, 0.8));
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
}

// Beyond what parts have, but constant to within the noise: it is not the hand.
TEST(Verdict, a_large_bias_of_the_accelerometer_is_not_taken_for_a_moving_hand) {
  const Calibration c = with_acc_bias(Vector3(0.6, -1.8, 0.5));
  EXPECT_EQ(c.trust.verdict, Verdict::kLimited);
  ASSERT_FALSE(c.trust.reasons.empty());
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("accelerometer's bias comes out as"));
}

TEST(Verdict, a_still_recording_without_noise_gives_no_nan) {
  Recording r = turning(Vector3::Zero(), 30.0);
  for (VectorSeries* series : {&r.acc, &r.gyr, &r.mag[0]}) {
    for (Vector3& v : series->v) v = series->v.front();
  }
  expect_refused(calibrate(r));
}

// At 400 Hz nodes take the mean of the two, which fits well.
TEST(Verdict, rows_of_two_devices_are_no_however_well_they_fit) {
  Recording r = test::simulated_hand(400.0, 1, 40.0).recording;
  VectorSeries& mag = r.mag.front();
  for (std::size_t k = 0; k < mag.size(); k += 3) mag.v[k] += Vector3(12.0, -8.0, 10.0);
  const Calibration c = calibrate(r);
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  ASSERT_FALSE(c.trust.reasons.empty());
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("every third sample of mag stands out"));
}

TEST(Verdict, a_fault_lowers_a_yes_only_where_it_ruins_every_calibration) {
  Trust trust;
  trust.verdict = Verdict::kYes;
  judge_faults(trust, {{"a few samples hang", false}});
  EXPECT_EQ(trust.verdict, Verdict::kYes);
  judge_faults(trust, {{"a few samples hang", false}, {"rows of two devices", true}});
  EXPECT_EQ(trust.verdict, Verdict::kNo);
  EXPECT_THAT(trust.reasons, testing::ElementsAre("a few samples hang", "rows of two devices"));
}

TEST(Verdict, a_short_recording_is_no_with_a_remedy) {
  const Calibration c = calibrate(turning(Vector3(0, 0, 0.5), 3.0));
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  EXPECT_THAT(c.trust.reasons.front(),
              AllOf(HasSubstr("turning.csv"), HasSubstr("too short"), HasSubstr("a minute")));
}

TEST(Verdict, a_recording_without_magnetometer_is_an_error_with_a_remedy) {
  Recording r = turning(Vector3(0, 0, 0.5), 30.0);
  r.mag.clear();
  const InputError error = test::error_of([&] { calibrate(r); });
  EXPECT_THAT(error.problem, HasSubstr("no magnetometer"));
  EXPECT_FALSE(error.remedy.empty());
}

TEST(Verdict, no_recording_is_an_error) {
  const InputError error =
      test::error_of([] { calibrate(std::vector<const Recording*>{}, CalibrationOptions{}); });
  EXPECT_FALSE(error.problem.empty());
}

TEST(Verdict, a_few_seconds_of_motion_give_numbers_and_an_honest_verdict) {
  const Simulation s = test::simulated_hand(50.0, 3, 8.0);
  const Calibration c = calibrate(s.recording, test::same_model(s));
  expect_no_null(to_json(c));
  if (c.trust.verdict == Verdict::kYes) test::expect_consistent(c, s.truth.parameters);
}

TEST(Verdict, a_good_recording_is_trusted) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Simulation s = test::simulated_hand(50.0, seed);
    CalibrationOptions options;
    options.gravity = s.truth.gravity;
    const Calibration c = calibrate(s.recording, options);
    EXPECT_EQ(c.trust.verdict, Verdict::kYes)
        << "seed " << seed << ": " << testing::PrintToString(c.trust.reasons);
    EXPECT_TRUE(c.undetermined.empty());
    expect_no_null(to_json(c));
  }
}

TEST(Trust, the_gravest_reason_comes_first_and_a_verdict_never_rises) {
  Trust trust;
  trust.lower(Verdict::kLimited, "limited");
  trust.lower(Verdict::kNo, "no");
  trust.lower(Verdict::kLimited, "limited too");
  EXPECT_EQ(trust.verdict, Verdict::kNo);
  EXPECT_THAT(trust.reasons, testing::ElementsAre("no", "limited", "limited too"));
}

TEST(Verdict, names_the_moment_when_a_magnet_was_put_on) {
  Simulation s = test::simulated_hand(20.0, 3, 100.0);
  VectorSeries& mag = s.recording.mag.front();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (mag.t[k] >= 50.0) mag.v[k] += Vector3(4.0, -3.0, 2.0);
  }
  const Calibration whole = calibrate_whole({&s.recording});
  EXPECT_NE(whole.trust.verdict, Verdict::kYes);
  EXPECT_THAT(whole.trust.reasons,
              testing::Contains(testing::ContainsRegex("for good at about (49|50|51) s")));
  const Calibration since = calibrate(s.recording);
  EXPECT_EQ(since.trust.verdict, Verdict::kYes);
  EXPECT_THAT(
      since.warnings,
      testing::Contains(testing::ContainsRegex("At about (49|50|51) s .* changed for good")));
}

}  // namespace
}  // namespace magimu
