// SPDX-License-Identifier: BSD-3-Clause
// The answer of a diagnosis follows from all of its evidence.
#include "diagnosis/conclude/conclude.h"

#include <gmock/gmock.h>

#include "diagnosis/conclude/contradictions.h"
#include "sim/simulate.h"
#include "tests/diagnosis/example_diagnosis.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

Departure departure(const char* channel, double z) {
  return {channel, "correlation", 0.97, 0.0, {-0.03, 0.03}, z, 20.0, 40.0, "hand.csv"};
}

TEST(Answer, is_made_from_findings_structure_and_trust) {
  EXPECT_EQ(conclude(test::example_diagnosis()).answer, Answer::kPartly);
  EXPECT_EQ(conclude(test::unexplained_diagnosis()).answer, Answer::kUnexplained);
  EXPECT_EQ(conclude(test::clean_diagnosis()).answer, Answer::kPredicts);
  EXPECT_EQ(conclude(test::empty_diagnosis()).answer, Answer::kNone);
  Diagnosis untrusted = test::clean_diagnosis();
  untrusted.after.trust.lower(Verdict::kNo, "The sensor hardly turned.");
  EXPECT_EQ(conclude(untrusted).answer, Answer::kNone) << "its silence means nothing";
  EXPECT_THAT(conclude(untrusted).evidence, Contains("The sensor hardly turned."));
}

TEST(Answer, is_none_where_the_fit_has_not_come_to_its_end) {
  Diagnosis d = test::unexplained_diagnosis();
  d.after.fit.reason = StopReason::kMaxIterations;
  d.after.trust.lower(Verdict::kNo, "The optimization did not reach the optimum.");
  const Conclusion c = conclude(d);
  EXPECT_EQ(c.answer, Answer::kNone);
  EXPECT_THAT(c.evidence, testing::ElementsAreArray(d.after.trust.reasons));
}

TEST(Answer, is_never_predicts_above_evidence_to_the_contrary) {
  const auto damaged = [](auto damage) {
    Diagnosis d = test::clean_diagnosis();
    damage(d);
    return conclude(d);
  };
  const Conclusion departed =
      damaged([](Diagnosis& d) { d.departures_after = {departure("mag", 61.0)}; });
  EXPECT_EQ(departed.answer, Answer::kUnexplained);
  EXPECT_THAT(departed.evidence,
              Contains(testing::AllOf(HasSubstr("correlation"), HasSubstr("20 to 40 s"),
                                      HasSubstr("61 standard deviations"))));
  const Conclusion halves = damaged([](Diagnosis& d) {
    d.after.checks.push_back({"halves", CheckStatus::kCaution, 3.0, "The halves disagree."});
  });
  EXPECT_EQ(halves.answer, Answer::kUnexplained);
  EXPECT_THAT(halves.evidence, Contains("The halves disagree."));
  const Conclusion aside = damaged([](Diagnosis& d) {
    d.after.set_aside = {
        {"hand.csv", {"acc", "spike", 1, 6000, 12.3, 12.3, "acc_x = 98000 m/s^2 at 12.34 s"}}};
  });
  EXPECT_EQ(aside.answer, Answer::kExplained);
  EXPECT_THAT(aside.evidence, Contains(HasSubstr("acc_x = 98000 m/s^2 at 12.34 s")));
  EXPECT_EQ(damaged([](Diagnosis& d) { d.statistics = 0; }).answer, Answer::kNone);
}

TEST(Answer, is_explained_where_a_cause_leaves_crumbs_only) {
  Diagnosis d = test::example_diagnosis();
  d.structure = {};
  d.departures = {departure("mag", 200.0)};
  EXPECT_EQ(conclude(d).answer, Answer::kExplained);
  d.departures_after = {departure("mag", 6.0)};
  EXPECT_EQ(conclude(d).answer, Answer::kExplained);
  d.departures_after = {departure("mag", 60.0)};
  EXPECT_EQ(conclude(d).answer, Answer::kPartly);
  d.departures_after = {departure("gyr", 6.0)};
  EXPECT_EQ(conclude(d).answer, Answer::kPartly) << "there it was not before";
}

class Findings : public testing::Test {
 protected:
  Findings() {
    SimulationOptions o;
    o.motion = SimulatedMotion::kHand;
    o.duration_s = 30.0;
    o.rate_hz = 50.0;
    recording_ = simulate(o).recording;
  }
  Diagnosis with(const char* effect, std::vector<FoundParameter> parameters) const {
    Diagnosis d;
    Finding f;
    f.effect = effect;
    f.sentence = "As it was.";
    f.parameters = std::move(parameters);
    d.findings.push_back(f);
    return d;
  }
  Recording recording_;
};

TEST_F(Findings, half_a_gyroscope_interval_is_a_convention_and_no_magnetometer_that_is_ahead) {
  const auto sentence_of = [&](double tau_s, double sigma_s) {
    Diagnosis d = with("mag_time_offset", {{"tau", tau_s, sigma_s, "s"}});
    reword_by_what_is_known({&recording_}, d);
    return d.findings.front().sentence;
  };
  EXPECT_THAT(sentence_of(-0.0098, 2e-4), HasSubstr("--gyro-interval centred"));
  EXPECT_THAT(sentence_of(-0.0201, 2e-4), HasSubstr("--gyro-interval backward"));
  EXPECT_THAT(sentence_of(-0.009, 5e-3), HasSubstr("perhaps"));
  EXPECT_EQ(sentence_of(0.010, 2e-4), "As it was.");
  EXPECT_EQ(sentence_of(-0.050, 2e-4), "As it was.");
}

TEST_F(Findings, two_sensors_that_are_ahead_alike_make_the_gyroscope_late) {
  const auto sentences_of = [&](double mag_s, double acc_s) {
    Diagnosis d = with("mag_time_offset", {{"tau", mag_s, 1e-4, "s"}});
    Finding acc = d.findings.front();
    acc.effect = "acc_time_offset";
    acc.parameters = {{"tau", acc_s, 4e-4, "s"}};
    d.findings.push_back(acc);
    reword_by_what_is_known({&recording_}, d);
    return std::pair(d.findings[0].sentence, d.findings[1].sentence);
  };
  const auto [mag, acc] = sentences_of(-0.0260, -0.0265);
  EXPECT_THAT(mag, HasSubstr("it is the gyroscope that is late"));
  EXPECT_THAT(acc, HasSubstr("it is the gyroscope that is late"));
  // 4.4 ms beyond an interval of 20 ms is no convention.
  EXPECT_THAT(sentences_of(-0.0244, -0.0243).first, HasSubstr("low-pass"));
  EXPECT_THAT(sentences_of(-0.0244, -0.0243).first, HasSubstr("20.00 ms, is that"));
  EXPECT_THAT(sentences_of(-0.0201, -0.0203).first, HasSubstr("--gyro-interval backward"));
  EXPECT_EQ(sentences_of(-0.0260, -0.0300).first, "As it was.");  // ten sigma apart
  EXPECT_EQ(sentences_of(0.0260, 0.0260).first, "As it was.");    // behind it
}

TEST_F(Findings, what_is_worth_a_hundredth_of_a_gyroscope_s_delay_may_be_the_rest_of_its_filter) {
  const auto named_beside = [&](double mag_tau_s, double nats, const char* other = "gravity") {
    Diagnosis d = with("mag_time_offset", {{"tau", mag_tau_s, 1e-4, "s"}});
    Finding acc = d.findings.front(), third = acc;
    d.findings.front().gain.heldout_nll_before = 10000.0;
    acc.effect = "acc_time_offset";
    acc.parameters = {{"tau", -0.0261, 4e-4, "s"}};
    acc.gain.heldout_nll_before = 1000.0;
    third.effect = other;
    third.parameters = {{"t0", 10.0, 0.1, "s"}, {"t1", 20.0, 0.1, "s"}};  // of a change
    third.gain.heldout_nll_before = nats;
    d.findings.push_back(acc);
    d.findings.push_back(third);
    withdraw_contradicted({&recording_}, d);
    return d.findings.size() == 3;
  };
  EXPECT_FALSE(named_beside(-0.0260, 90.0));
  EXPECT_TRUE(named_beside(-0.0260, 130.0));
  EXPECT_TRUE(named_beside(-0.0160, 90.0));  // the magnetometer's own
  // No filter begins or drifts.
  EXPECT_TRUE(named_beside(-0.0260, 90.0, "hard_iron_change"));
  EXPECT_TRUE(named_beside(-0.0260, 90.0, "mag_gain_drift"));
}

TEST_F(Findings, a_wrong_clock_is_not_named_where_the_times_are_bad_one_by_one) {
  Diagnosis steady = with("clock_scale", {{"kappa", 0.02, 1e-3, "1"}});
  withdraw_contradicted({&recording_}, steady);
  EXPECT_EQ(steady.findings.size(), 1u);

  // Stamped on arrival, four at a time.
  for (std::size_t k = 0; k < recording_.gyr.size(); ++k) {
    recording_.gyr.t[k] = 0.08 * double(k / 4) + 2e-4 * double(k % 4);
  }
  Diagnosis bursts = with("clock_scale", {{"kappa", 0.02, 1e-3, "1"}});
  withdraw_contradicted({&recording_}, bursts);
  EXPECT_TRUE(bursts.findings.empty());
  EXPECT_TRUE(bursts.structure.detected);
  EXPECT_THAT(bursts.structure.evidence.front(), HasSubstr("jitter"));
}

TEST_F(Findings, nothing_is_attached_to_a_resting_sensor_that_is_brought_near_and_taken_away) {
  Diagnosis d = with("hard_iron_change", {{"s[0]", 3.0, 0.1, "uT"},
                                          {"s[1]", 0.0, 0.1, "uT"},
                                          {"s[2]", 0.0, 0.1, "uT"},
                                          {"t0", 1.0, 0.1, "s"},
                                          {"t1", 2.0, 0.1, "s"}});
  reword_by_what_is_known({&recording_}, d);
  EXPECT_THAT(d.findings.front().sentence, HasSubstr("While the sensor rested"));
  d.findings.front().parameters[4].value = 20.0;
  d.findings.front().sentence = "As it was.";
  reword_by_what_is_known({&recording_}, d);
  EXPECT_EQ(d.findings.front().sentence, "As it was.");
}

}  // namespace
}  // namespace magimu
