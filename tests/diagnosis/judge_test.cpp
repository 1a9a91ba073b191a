// SPDX-License-Identifier: BSD-3-Clause
// The judge of diagnoses, on findings made up for it.
#include "bench/power/judge_diagnosis.h"

#include <gmock/gmock.h>

#include <limits>

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

HiddenCase hiding(const std::string& effect) { return draw_case(effect, 1); }

Finding finding(const std::string& effect, const std::string& channel, double gain) {
  Finding f;
  f.effect = effect;
  f.channel = channel;
  f.gain.heldout_nll_before = gain;
  return f;
}

TEST(Judge, knows_the_name_its_class_and_the_simpler_cause) {
  Diagnosis d;
  d.findings = {finding("mag_time_offset", "mag", 100.0)};
  EXPECT_THAT(judge(d, hiding("mag_time_offset")).naming, ElementsAre(Naming::kRight));
  EXPECT_THAT(judge(d, hiding("mag_lag")).naming, ElementsAre(Naming::kSameClass));
  const Judgement nested = judge(d, hiding("mag_eddy_current"));
  EXPECT_THAT(nested.naming, ElementsAre(Naming::kNested));
  EXPECT_THAT(nested.others, IsEmpty());
  EXPECT_FALSE(nested.right());
  const Judgement wrong = judge(d, hiding("mag_nonlinearity"));
  EXPECT_THAT(wrong.naming, ElementsAre(Naming::kWrong));
  EXPECT_THAT(wrong.others, ElementsAre("mag_time_offset"));
}

TEST(Judge, tells_silence_from_what_is_said_to_be_unexplained) {
  Diagnosis d;
  EXPECT_THAT(judge(d, hiding("mag_lag")).naming, ElementsAre(Naming::kNothing));
  d.unexplained.detected = true;
  EXPECT_THAT(judge(d, hiding("mag_lag")).naming, ElementsAre(Naming::kUnexplained));
}

TEST(Judge, noise_belongs_to_a_sensor) {
  HiddenCase c = hiding("outliers");
  c.options.effects.front().channel = oracle::Channel::kAcc;
  Diagnosis d;
  d.findings = {finding("outliers", "mag", 10.0)};
  EXPECT_THAT(judge(d, c).naming, ElementsAre(Naming::kWrong));
  d.findings.push_back(finding("outliers", "acc", 100.0));
  const Judgement j = judge(d, c);
  EXPECT_THAT(j.naming, ElementsAre(Naming::kRight));
  EXPECT_THAT(j.others, ElementsAre("outliers"));
  EXPECT_NEAR(j.others_share, 0.1, 1e-12);
}

TEST(Judge, the_motion_of_a_hand_is_there_where_there_is_a_hand) {
  HiddenCase c = hiding("mag_lag");
  Diagnosis d;
  d.findings = {finding("linear_acceleration", "acc", 1e6), finding("mag_lag", "mag", 100.0)};
  c.options.motion.kind = oracle::MotionKind::kHandHeld;
  EXPECT_THAT(judge(d, c).others, IsEmpty());
  c.options.motion.kind = oracle::MotionKind::kRotation;
  EXPECT_THAT(judge(d, c).others, ElementsAre("linear_acceleration"));
}

TEST(Judge, a_change_that_lasts_may_end_after_the_recording) {
  const oracle::Effect truth = oracle::make_effect(
      "hard_iron_change", {1.0, 2.0, 3.0, 40.0, std::numeric_limits<double>::infinity()});
  oracle::Options options;
  options.motion.duration_s = 100.0;
  Finding f;
  for (const double value : {1.01, 2.0, 3.0, 40.0, 100.0}) {
    f.parameters.push_back({"", value, 0.01, ""});
  }
  EXPECT_NEAR(farthest_sigma(f, truth, options), 1.0, 1e-9);
  f.parameters[4].value = 70.0;
  EXPECT_GT(farthest_sigma(f, truth, options), 1e6);
}

TEST(Judge, folds_frequencies_above_half_the_rate) {
  oracle::Options options;
  options.rate_hz = 80.0;
  const oracle::Effect truth =
      oracle::make_effect("mains_interference", {1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 50.0});
  Finding f;
  // cos(2 pi 50 k / 80) = cos(2 pi 30 k / 80), and the sine changes its sign.
  for (const double value : {1.0, 2.0, 3.0, -0.1, -0.2, -0.3, 30.0}) {
    f.parameters.push_back({"", value, 0.01, ""});
  }
  EXPECT_LT(farthest_sigma(f, truth, options), 1e-9);
  f.parameters[0].value = 1.05;
  EXPECT_NEAR(farthest_sigma(f, truth, options), 5.0, 1e-9);
}

}  // namespace
}  // namespace magimu
