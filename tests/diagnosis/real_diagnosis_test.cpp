// SPDX-License-Identifier: BSD-3-Clause
// Real hands (BROAD), of which other studies know what is wrong: the magnetometer lags, the hand
// moves the sensor, and magnets and taps were meant to disturb.
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "diagnosis/diagnosis.h"
#include "recording/read.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::Field;
using testing::Not;

const Finding* find(const Diagnosis& d, const std::string& effect) {
  for (const Finding& f : d.findings) {
    if (f.effect == effect) return &f;
  }
  return nullptr;
}

std::string sentences(const Diagnosis& d) {
  std::string text = "findings:";
  for (const Finding& f : d.findings) text += "\n  " + f.effect + ": " + f.sentence;
  return text;
}

class RealRecording : public testing::Test {
 protected:
  // Once a recording, for all tests that the program runs.
  static const Diagnosis* diagnosed(const std::string& number) {
    static std::map<std::string, Diagnosis> known;
    if (const auto it = known.find(number); it != known.end()) return &it->second;
    const std::filesystem::path folder = std::filesystem::path(MAGIMU_DATA_DIR) / "broad";
    if (!std::filesystem::exists(folder)) return nullptr;
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
      if (file.path().filename().string().rfind(number + "_", 0) != 0) continue;
      return &(known[number] = diagnose(read_recording(file.path().string())));
    }
    return nullptr;
  }
};

// Skips the test where the recording is absent.
#define DIAGNOSED(d, number)                                           \
  const Diagnosis* d##_pointer = diagnosed(number);                    \
  if (!d##_pointer) {                                                  \
    GTEST_SKIP() << "This test needs the BROAD recording " << (number) \
                 << ", which is not part of the project.";             \
  }                                                                    \
  const Diagnosis& d = *d##_pointer

class LaggingMagnetometer : public RealRecording,
                            public testing::WithParamInterface<const char*> {};

TEST_P(LaggingMagnetometer, is_found_and_nothing_that_resembles_it) {
  DIAGNOSED(d, GetParam());
  const Finding* lag = find(d, "mag_time_offset");
  if (!lag) lag = find(d, "mag_lag");  // to first order the same
  ASSERT_NE(lag, nullptr) << sentences(d);
  EXPECT_GE(lag->parameters.front().value, 9e-3) << sentences(d);
  EXPECT_LE(lag->parameters.front().value, 13.5e-3) << sentences(d);
  EXPECT_THAT(d.findings, Not(Contains(Field(&Finding::effect, "mag_eddy_current"))));
  EXPECT_THAT(d.findings, Not(Contains(Field(&Finding::effect, "gyro_g_sensitivity"))));
  // In motion it seems to wander; at rest it does not.
  EXPECT_THAT(d.findings, Not(Contains(Field(&Finding::effect, "gyro_bias_drift"))));
}

INSTANTIATE_TEST_SUITE_P(Broad, LaggingMagnetometer, testing::Values("02", "03", "07"));

// Their magnetometer measures every 10 ms and is read every 7: it is as old again after 70 ms. The
// harmonics of that look like lines of the mains.
class SlowerClock : public RealRecording, public testing::WithParamInterface<const char*> {};

TEST_P(SlowerClock, is_told_by_its_pattern) {
  DIAGNOSED(d, GetParam());
  EXPECT_THAT(d.unexplained.evidence,
              Contains(testing::HasSubstr("in a pattern that repeats every 70 ms")));
  EXPECT_THAT(d.findings, Not(Contains(Field(&Finding::effect, "mains_interference"))));
}

INSTANTIATE_TEST_SUITE_P(Broad, SlowerClock, testing::Values("03", "07", "24", "33"));

class MovedSensor : public RealRecording, public testing::WithParamInterface<const char*> {};

TEST_P(MovedSensor, the_motion_of_the_hand_is_found) {
  DIAGNOSED(d, GetParam());
  const Finding* hand = find(d, "linear_acceleration");
  ASSERT_NE(hand, nullptr) << sentences(d);
  EXPECT_LT(hand->gain.heldout_nll_after, hand->gain.heldout_nll_before);
}

INSTANTIATE_TEST_SUITE_P(Broad, MovedSensor, testing::Values("02", "03", "07", "11", "21"));

using RealDiagnosis = RealRecording;

TEST_F(RealDiagnosis, finds_the_attached_magnet_and_when_it_was_removed) {
  DIAGNOSED(d, "33");
  const Finding* magnet = find(d, "hard_iron_change");
  ASSERT_NE(magnet, nullptr) << sentences(d);
  ASSERT_EQ(magnet->parameters.size(), 5u);  // s, t0, t1
  const double known[] = {-3.1, -0.3, 27.2};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(magnet->parameters[i].value, known[i], 1.0) << sentences(d);
  }
  EXPECT_NEAR(magnet->parameters[4].value, 98.3, 1.0) << sentences(d);
}

TEST_F(RealDiagnosis, finds_the_stationary_magnet) {
  DIAGNOSED(d, "29");
  EXPECT_NE(find(d, "stationary_source"), nullptr) << sentences(d);
}

TEST_F(RealDiagnosis, finds_the_taps) {
  DIAGNOSED(d, "24");
  EXPECT_THAT(d.findings, Contains(testing::AllOf(Field(&Finding::effect, "outliers"),
                                                  Field(&Finding::channel, "acc"))))
      << sentences(d);
  // Beside them an accelerometer 5 % off, which no other recording of these sensors has.
  EXPECT_EQ(find(d, "acc_scale_misalignment"), nullptr) << sentences(d);
}

TEST_F(RealDiagnosis, every_finding_gains_on_what_it_was_not_fitted_to) {
  int looked_at = 0;
  for (const char* number : {"02", "03", "07", "11", "21", "24", "29", "33"}) {
    const Diagnosis* d = diagnosed(number);
    if (!d) continue;
    ++looked_at;
    for (const Finding& f : d->findings) {
      EXPECT_LT(f.gain.heldout_nll_after, f.gain.heldout_nll_before) << number << ": " << f.effect;
    }
  }
  if (looked_at == 0) GTEST_SKIP() << "This test needs recordings of BROAD.";
}

}  // namespace
}  // namespace magimu
