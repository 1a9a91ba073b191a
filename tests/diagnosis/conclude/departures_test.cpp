// SPDX-License-Identifier: BSD-3-Clause
// Whatever begins, ends or changes in mid-recording leaves the bands of the final model, and then
// the simulation does not predict the data; where nothing is wrong, nothing leaves them.
#include "diagnosis/conclude/departures.h"

#include <gmock/gmock.h>

#include <cmath>

#include "sim/simulate.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

SimulationOptions hand(std::uint64_t seed, SimulatedMotion motion = SimulatedMotion::kHand) {
  SimulationOptions o;
  o.motion = motion;
  o.rate_hz = 50.0;
  o.duration_s = 60.0;
  o.seed = seed;
  o.gravity = kStandardGravity;
  return o;
}

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> out;
  for (const Finding& f : d.findings) out.push_back(f.effect + " (" + f.channel + ")");
  return out;
}

TEST(Bands, are_left_by_one_of_all_statistics_in_three_recordings_of_a_thousand) {
  const double one = level_of_one(477);
  EXPECT_NEAR(1.0 - std::pow(1.0 - one, 477), kSimultaneous, 1e-12);
  EXPECT_EQ(level_of_one(0), level_of_one(1));
}

class NothingWrong : public testing::TestWithParam<SimulatedMotion> {};

TEST_P(NothingWrong, leaves_no_band) {
  for (std::uint64_t seed = 11; seed < 15; ++seed) {
    const Diagnosis d = diagnose(simulate(hand(seed, GetParam())).recording);
    EXPECT_GT(d.statistics, 300);
    EXPECT_THAT(d.departures_after, IsEmpty()) << seed << ", " << d.departures_after[0].statistic;
    EXPECT_FALSE(d.unexplained.detected) << seed << ", " << d.unexplained.evidence.front();
  }
}

INSTANTIATE_TEST_SUITE_P(Simulated, NothingWrong,
                         testing::Values(SimulatedMotion::kHand, SimulatedMotion::kHandHeld),
                         [](const auto& test) { return to_string(test.param); });

struct MidRecording {
  const char* name;
  void (*damage)(Recording&);
};
void PrintTo(const MidRecording& m, std::ostream* out) { *out << m.name; }

constexpr double kMiddle = 30.0;  // s

void gain_of_an_axis(Recording& r) {
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    if (r.mag[0].t[k] > kMiddle) r.mag[0].v[k][0] *= 1.01;
  }
}
void soft_iron(Recording& r) {
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    Vector3& v = r.mag[0].v[k];
    if (r.mag[0].t[k] > kMiddle) v += 0.01 * Vector3(v[1], v[0], 0.0);
  }
}
void gyroscopes_gain(Recording& r) {
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    if (r.gyr.t[k] > kMiddle) r.gyr.v[k] *= 1.02;
  }
}
void passing_phone(Recording& r) {
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    const double t = r.mag[0].t[k] - kMiddle;
    if (t > 0.0 && t < 3.0) r.mag[0].v[k][1] += 23.0 * std::sin(M_PI * t / 3.0);
  }
}
void second_device(Recording& r) {
  const Recording other = simulate(hand(977)).recording;
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    if (r.mag[0].t[k] > kMiddle) r.mag[0].v[k] = other.mag[0].v[k];
  }
}
void motors_current(Recording& r) {
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    if (std::fmod(r.mag[0].t[k], 7.0) > 4.0) r.mag[0].v[k] += Vector3(0.5, -0.3, 0.2);
  }
}

class Changes : public testing::TestWithParam<MidRecording> {};

TEST_P(Changes, forbid_predicts) {
  Recording r = simulate(hand(21)).recording;
  GetParam().damage(r);
  const Diagnosis d = diagnose(r);
  EXPECT_TRUE(d.answer == Answer::kUnexplained || d.answer == Answer::kPartly ||
              d.answer == Answer::kExplained)
      << to_string(d.answer);
  EXPECT_TRUE(!d.departures_after.empty() || !d.findings.empty());
  EXPECT_FALSE(d.evidence.empty() && d.findings.empty());
}

INSTANTIATE_TEST_SUITE_P(InMidRecording, Changes,
                         testing::Values(MidRecording{"gain_of_an_axis", gain_of_an_axis},
                                         MidRecording{"soft_iron", soft_iron},
                                         MidRecording{"gyroscopes_gain", gyroscopes_gain},
                                         MidRecording{"passing_phone", passing_phone},
                                         MidRecording{"second_device", second_device},
                                         MidRecording{"motors_current", motors_current}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Changes, say_in_which_part_of_the_recording_they_show) {
  Recording r = simulate(hand(21)).recording;
  gain_of_an_axis(r);
  const Diagnosis d = diagnose(r);
  EXPECT_THAT(d.departures,
              Contains(testing::AllOf(Field(&Departure::statistic, "x against the field's x"),
                                      Field(&Departure::end_s, testing::Gt(0.0)))));
}

TEST(Changes, of_gains_are_not_what_passes_by) {
  Recording r = simulate(hand(61)).recording;
  passing_phone(r);
  const Diagnosis d = diagnose(r);
  EXPECT_NE(d.answer, Answer::kPredicts);
  EXPECT_THAT(names(d), testing::Not(Contains("mag_change (mag)")));
  EXPECT_THAT(names(d), testing::Not(Contains("gyro_change (gyr)")));
}

TEST(Lines, in_step_with_the_samples_are_no_mains) {
  for (const std::size_t every : {2U, 3U}) {
    Recording r = simulate(hand(26)).recording;
    for (std::size_t k = 0; k < r.mag[0].size(); k += every) {
      r.mag[0].v[k] += Vector3(2.0, -1.5, 1.0);
    }
    const Diagnosis d = diagnose(r);
    EXPECT_THAT(names(d), testing::Not(Contains("mains_interference (mag)")));
    EXPECT_EQ(d.answer, Answer::kUnexplained) << to_string(d.answer);
    EXPECT_THAT(d.evidence, Contains(HasSubstr(every == 2 ? "Every second" : "Every third")));
    // Where densities are given, their size is not doubted for it.
    DiagnosisOptions options;
    options.noise = SimulationOptions().noise;
    EXPECT_THAT(names(diagnose(r, options)), testing::Not(Contains("noise_scale (mag)")));
  }
}

// The rests at the ends are cut before anything is fitted.
TEST(CutRests, tell_of_a_magnet_that_is_laid_beside_the_resting_sensor) {
  SimulationOptions o = hand(22);
  o.rest_s = 20.0;
  o.duration_s = 80.0;
  Recording r = simulate(o).recording;
  EXPECT_FALSE(diagnose(r).unexplained.detected);
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    if (r.mag[0].t[k] > 5.0 && r.mag[0].t[k] < 10.0) r.mag[0].v[k] += Vector3(0.5, 0.0, 0.0);
  }
  const Diagnosis d = diagnose(r);
  EXPECT_EQ(d.answer, Answer::kUnexplained);
  EXPECT_THAT(d.evidence, Contains(HasSubstr("While the sensor rested")));
  EXPECT_THAT(names(d), IsEmpty());
}

// The samples that a coarse converter repeats are samples: the first of each level alone would be
// from the time when it changed, as if the magnetometer were ahead.
TEST(Quantization, alone_is_the_only_thing_named) {
  Recording r = simulate(hand(23)).recording;
  for (Vector3& v : r.mag[0].v) v = 1.5 * (v / 1.5).array().round().matrix();
  const Diagnosis d = diagnose(r);
  EXPECT_THAT(names(d), testing::ElementsAre("mag_quantization (mag)"));
  EXPECT_EQ(d.answer, Answer::kExplained);
}

// The paper's motion jitters as fast as noise, and the accelerometer and the magnetometer say so.
TEST(TrueDensities, of_the_default_simulation_yield_no_finding) {
  SimulationOptions o;
  o.gravity = kStandardGravity;
  DiagnosisOptions options;
  options.noise = o.noise;
  const Diagnosis d = diagnose(simulate(o).recording, options);
  EXPECT_THAT(names(d), IsEmpty());
  EXPECT_EQ(d.answer, Answer::kPredicts);
}

// Noise is looked for in all recordings, whichever comes first.
TEST(TwoRecordings, have_the_same_findings_in_either_order) {
  SimulationOptions o = hand(24);
  o.duration_s = 120.0;
  const Recording all = simulate(o).recording;
  const Recording good = slice(all, 0.0, 60.0);
  Recording bad = slice(all, 60.0, 120.0);
  for (std::size_t k = 10; k < bad.mag[0].size(); k += 50) {
    bad.mag[0].v[k] += (k % 100 == 10 ? 1.0 : -1.0) * Vector3(2.0, -1.5, 1.0);
  }
  const Diagnosis one = diagnose({&good, &bad}), other = diagnose({&bad, &good});
  EXPECT_THAT(names(one), testing::UnorderedElementsAreArray(names(other)));
  EXPECT_THAT(names(one), Contains("outliers (mag)"));
  EXPECT_EQ(one.answer, other.answer);
}

}  // namespace
}  // namespace magimu
