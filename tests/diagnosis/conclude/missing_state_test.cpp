// SPDX-License-Identifier: BSD-3-Clause
// The answer is bound by the evidence of what the model lacks.
#include "diagnosis/conclude/missing_state.h"

#include <gmock/gmock.h>

#include "diagnosis/result/diagnosis_json.h"
#include "sim/simulate.h"
#include "tests/diagnosis/example_diagnosis.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// In the order field, magnetometer, gyroscope, accelerometer.
std::vector<MissingState> missing(std::array<double, 4> gained, std::array<double, 4> left) {
  const char* const channel[] = {"mag", "mag", "gyr", "acc"};
  const char* const frame[] = {"navigation", "sensor", "sensor", "sensor"};
  const char* const unit[] = {"uT", "uT", "rad/s", "m/s^2"};
  std::vector<MissingState> out;
  for (std::size_t i = 0; i < 4; ++i) {
    out.push_back({channel[i], frame[i], unit[i], gained[i], left[i], 0.0, 0.3, 5.0, ""});
  }
  return out;
}

TEST(MissingState, forbids_to_say_that_the_simulation_predicts_the_data) {
  Diagnosis d = test::clean_diagnosis();
  d.missing = missing({0.0, 5.0, 1.0, 0.0}, {0.0, 5.0, 1.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kPredicts) << "chance gains as much";
  d.missing = missing({20.0, 31.0, 1.0, 0.0}, {20.0, 31.0, 1.0, 0.0});
  const Conclusion c = conclude(d);
  EXPECT_EQ(c.answer, Answer::kUnexplained);
  EXPECT_THAT(c.evidence, Contains(AllOf(HasSubstr("in the magnetometer:"), HasSubstr("31 nats"),
                                         HasSubstr("0.3 uT"), Not(HasSubstr("gyroscope")))));
}

TEST(MissingState, lasts_no_longer_than_the_recording) {
  Diagnosis d = test::clean_diagnosis();
  d.missing = missing({20.0, 31.0, 1.0, 0.0}, {20.0, 31.0, 1.0, 0.0});
  d.missing_series = {{.unit = "uT",
                       .t = {0.0, 30.0},
                       .mean = {Vector3::Ones(), Vector3::Zero()},
                       .sigma = {Vector3::Ones(), Vector3::Ones()}}};
  EXPECT_THAT(sentence_of_missing_state(d), HasSubstr("that lasts about 5 s"));
  for (MissingState& m : d.missing) m.memory_s = 190.0;
  EXPECT_THAT(sentence_of_missing_state(d),
              AllOf(HasSubstr("more slowly than the recording tells"), Not(HasSubstr("190"))));
}

TEST(MissingState, names_every_sensor_that_it_cannot_tell_from_the_best) {
  Diagnosis d = test::clean_diagnosis();
  d.missing = missing({95.0, 100.0, 98.0, 40.0}, {95.0, 100.0, 98.0, 40.0});
  const std::string said = sentence_of_missing_state(d);
  EXPECT_THAT(said, AllOf(HasSubstr("in itself or in the field about it"),
                          HasSubstr("or in the gyroscope"), Not(HasSubstr("accelerometer"))));
  d.missing = missing({20.0, 30.0, 700.0, 40.0}, {20.0, 30.0, 700.0, 40.0});
  EXPECT_THAT(sentence_of_missing_state(d),
              AllOf(HasSubstr("in the gyroscope:"), HasSubstr("deg/s")));
}

TEST(MissingState, tells_which_part_a_cause_takes_that_is_alone_on_its_sensor) {
  Diagnosis d = test::clean_diagnosis();
  Finding lag;
  lag.effect = "mag_time_offset";
  lag.channel = "mag";
  lag.sentence = "It lags.";
  d.findings = {lag};
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {300.0, 400.0, 0.0, 0.0});
  tell_shares_taken(d);
  EXPECT_THAT(d.findings[0].sentence, HasSubstr("It takes 60 % of the evidence"));
  d.findings = {lag};
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {3.0, 5.0, 0.0, 0.0});
  tell_shares_taken(d);
  EXPECT_EQ(d.findings[0].sentence, "It lags.");
  lag.effect = "mag_own_clock";
  d.findings.push_back(lag);
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {300.0, 400.0, 0.0, 0.0});
  tell_shares_taken(d);
  EXPECT_EQ(d.findings[0].sentence, "It lags.") << "which of the two takes it is not known";
}

TEST(MissingState, is_explained_where_causes_leave_what_decides_nothing) {
  Diagnosis d = test::example_diagnosis();
  d.structure = {};
  d.departures_after = {};
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {3.0, 5.0, 0.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kExplained);
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {3.0, 9.0, 0.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kExplained) << "of 1000";
  d.missing = missing({9e4, 1e5, 100.0, 0.0}, {3.0, 20.0, 0.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kPartly) << "a share that is small is evidence, too";
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {3.0, 400.0, 0.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kPartly);
  EXPECT_THAT(conclude(d).evidence, Contains(HasSubstr("before causes were named: 1000")));
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {3.0, 5.0, 50.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kPartly) << "in another sensor";
  d.missing[2].noise = "correlated_noise";
  EXPECT_EQ(conclude(d).answer, Answer::kExplained) << "that has a name";
}

TEST(MissingState, of_which_causes_take_nothing_is_unexplained) {
  Diagnosis d = test::example_diagnosis();
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {900.0, 999.0, 100.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kUnexplained) << "whatever was named";
  d.missing = missing({900.0, 1000.0, 100.0, 0.0}, {800.0, 900.0, 100.0, 0.0});
  EXPECT_EQ(conclude(d).answer, Answer::kPartly);
}

// Whatever is missing gives residuals some shape: a noise that is worth a crumb of it is that.
TEST(MissingState, keeps_a_noise_from_being_named_that_is_worth_a_crumb_of_it) {
  const auto noise = [](const std::string& effect, const std::string& channel, double gain) {
    Finding f;
    f.effect = effect;
    f.channel = channel;
    f.gain.heldout_nll_before = gain;
    return f;
  };
  const auto named = [&](double mag, const std::string& process) {
    Diagnosis d;
    d.findings = {noise("correlated_noise", "mag", mag), noise("outliers", "acc", 14.0),
                  noise("mag_time_offset", "mag", 14.0)};
    d.missing = missing({900.0, 6000.0, 100.0, 0.0}, {900.0, 6000.0, 100.0, 0.0});
    d.missing[0].noise = process;
    withdraw_crumbs_of_noise(d);
    return d.findings.size();
  };
  EXPECT_EQ(named(14.0, ""), 2U);
  EXPECT_EQ(named(1400.0, ""), 3U);
  EXPECT_EQ(named(14.0, "correlated_noise"), 3U) << "a process that it is";
}

TEST(MissingState, is_not_called_a_field_where_the_accelerometer_is_late) {
  Diagnosis d = test::clean_diagnosis();
  d.missing = missing({300.0, 200.0, 10.0, 20.0}, {300.0, 200.0, 10.0, 20.0});
  EXPECT_THAT(conclude(d).evidence, Contains(HasSubstr("To settle it")));
  for (MissingState& m : d.missing) {
    m.left_beside_acc_offset = 1.0;
    m.acc_offset_s = 0.004;
  }
  const Conclusion c = conclude(d);
  EXPECT_EQ(c.answer, Answer::kUnexplained);
  EXPECT_THAT(c.evidence, Contains(AllOf(HasSubstr("4.0 ms late"), Not(HasSubstr("field")))));
  EXPECT_THAT(c.evidence, Not(Contains(HasSubstr("To settle it"))));
}

TEST(MissingState, is_no_place_where_it_changes_while_the_sensor_rests) {
  Diagnosis d = test::clean_diagnosis();
  d.missing = missing({300.0, 295.0, 10.0, 20.0}, {300.0, 295.0, 10.0, 20.0});
  d.field_at_rest = AtRest{2, 0.1, 1.5, 10.0, 20.0, "hand.csv"};
  EXPECT_THAT(what_would_settle_it(d), AllOf(HasSubstr("(2 times)"), HasSubstr("To settle it")));
  d.field_at_rest->change_sigmas = 9.0;
  EXPECT_THAT(what_would_settle_it(d), AllOf(HasSubstr("not that the field differs"),
                                             HasSubstr("10 to 20 s"), HasSubstr("9 standard")));
  d.missing = missing({300.0, 395.0, 10.0, 20.0}, {300.0, 395.0, 10.0, 20.0});
  EXPECT_EQ(what_would_settle_it(d), "") << "it is the sensor";
}

// Such changes were said to be predicted, at hundreds of standard deviations.
TEST(MissingState, of_a_gain_that_changes_is_never_nothing) {
  SimulationOptions o;
  o.motion = SimulatedMotion::kHand;
  o.duration_s = 80.0;
  o.rate_hz = 50.0;
  o.seed = 11;
  Recording recording = simulate(o).recording;
  VectorSeries& mag = recording.mag.front();
  for (std::size_t k = mag.size() / 2; k < mag.size(); ++k) mag.v[k][0] *= 1.01;
  DiagnosisOptions options;
  options.gravity = o.gravity;
  const Diagnosis d = diagnose(recording, options);
  EXPECT_NE(d.answer, Answer::kPredicts);
  ASSERT_EQ(d.missing.size(), 4u);
  const double mag_gain = std::max(d.missing[0].gain_nats, d.missing[1].gain_nats);
  EXPECT_GT(mag_gain, d.missing[2].gain_nats + 10.0);
  EXPECT_GT(mag_gain, d.missing[3].gain_nats + 10.0);
  const nlohmann::ordered_json json = to_json(d);
  ASSERT_EQ(json["evidence"].size(), 4u);
  EXPECT_EQ(json["evidence"][1]["frame"], "sensor");
  if (state_is_missing(d)) {
    ASSERT_EQ(json["disturbance"].size(), 1u);
    EXPECT_EQ(json["disturbance"][0]["t"].size(), json["disturbance"][0]["mean"].size());
  }
}

}  // namespace
}  // namespace magimu
