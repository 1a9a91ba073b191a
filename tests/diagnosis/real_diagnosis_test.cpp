// SPDX-License-Identifier: BSD-3-Clause
// Real hands (BROAD), of which other studies know what is wrong: the magnetometer lags, the hand
// moves the sensor, and magnets and taps were meant to disturb.
#include <gmock/gmock.h>

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "diagnosis/compare/predict.h"
#include "diagnosis/result/diagnosis.h"
#include "recording/read.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::Field;

const Finding* finding_of(const Diagnosis& d, const std::string& effect) {
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

std::optional<Recording> recorded(const std::string& number) {
  const std::filesystem::path folder = std::filesystem::path(MAGIMU_DATA_DIR) / "broad";
  if (!std::filesystem::exists(folder)) return std::nullopt;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().filename().string().rfind(number + "_", 0) != 0) continue;
    return read_recording(file.path().string());
  }
  return std::nullopt;
}

// calibrated: with what calibrate() says of it, too, which takes half as long again.
std::optional<Diagnosis> diagnosed(const std::string& number, bool calibrated) {
  const std::optional<Recording> recording = recorded(number);
  if (!recording) return std::nullopt;
  DiagnosisOptions options;
  options.calibrate_before = calibrated;
  return diagnose(*recording, options);
}

void expect_a_lag(const Diagnosis& d) {
  const Finding* lag = finding_of(d, "mag_time_offset");
  if (!lag) lag = finding_of(d, "mag_lag");  // to first order the same
  ASSERT_NE(lag, nullptr);
  EXPECT_GE(lag->parameters.front().value, 9e-3);
  EXPECT_LE(lag->parameters.front().value, 13.5e-3);
}

// Their magnetometer measures every 10 ms and is read every 7: it is as old again after 70 ms. The
// harmonics of that look like lines of the mains.
void expect_a_slower_clock(const Diagnosis& d) {
  EXPECT_THAT(d.unexplained.evidence,
              Contains(testing::HasSubstr("in a pattern that repeats every 70 ms")));
}

// Recordings of one sensor do not agree on any of these.
void expect_nothing_invented(const Diagnosis& d) {
  for (const char* name :
       {"acc_scale_misalignment", "gyro_scale_misalignment", "clock_scale", "gyro_nonlinearity",
        "gyro_g_sensitivity", "gyro_bias_drift", "mag_nonlinearity", "mag_eddy_current",
        "field_drift", "hard_iron_drift", "mains_interference"}) {
    EXPECT_EQ(finding_of(d, name), nullptr) << name;
  }
}

void expect_the_hand(const Diagnosis& d) {
  EXPECT_NE(finding_of(d, "linear_acceleration"), nullptr);
}

void expect_the_attached_magnet_and_when_it_was_removed(const Diagnosis& d) {
  const Finding* magnet = finding_of(d, "hard_iron_change");
  ASSERT_NE(magnet, nullptr);
  ASSERT_EQ(magnet->parameters.size(), 5u);  // s, t0, t1
  const double known[] = {-3.1, -0.3, 27.2};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(magnet->parameters[i].value, known[i], 1.0);
  }
  EXPECT_NEAR(magnet->parameters[4].value, 98.3, 1.0);
  // Some 99 s between the rests at 286 Hz, not the means that were fitted.
  EXPECT_GT(d.before.samples, 25000);
}

void expect_the_stationary_magnet(const Diagnosis& d) {
  EXPECT_NE(finding_of(d, "stationary_source"), nullptr);
}

void expect_the_taps(const Diagnosis& d) {
  EXPECT_THAT(d.findings, Contains(testing::AllOf(Field(&Finding::effect, "outliers"),
                                                  Field(&Finding::channel, "acc"))));
}

struct Known {
  const char* number;
  std::vector<void (*)(const Diagnosis&)> of_it;
  const char* serves = "";  // another recording of the same sensor
};
void PrintTo(const Known& known, std::ostream* out) { *out << known.number; }

class RealDiagnosis : public testing::TestWithParam<Known> {};

TEST_P(RealDiagnosis, tells_what_is_known_and_gains_on_what_it_was_not_fitted_to) {
  // That with the magnet as the program does it.
  const std::optional<Diagnosis> d =
      diagnosed(GetParam().number, std::string(GetParam().number) == "33");
  if (!d) {
    GTEST_SKIP() << "This test needs the BROAD recording " << GetParam().number
                 << ", which is not part of the project.";
  }
  SCOPED_TRACE(sentences(*d));
  for (const auto& expect : GetParam().of_it) expect(*d);
  expect_nothing_invented(*d);
  // What has lost its name is not in the model either.
  for (const auto& effect : d->after.effects) {
    EXPECT_NE(finding_of(*d, effect.name), nullptr) << effect.name;
  }
  for (const Finding& f : d->findings) {
    EXPECT_LT(f.gain.heldout_nll_after, f.gain.heldout_nll_before) << f.effect;
  }
  // Another one, which nothing was fitted to, is predicted better than by the hand's motion alone.
  if (const std::string other = GetParam().serves; !other.empty()) {
    const std::optional<Recording> served = recorded(other);
    ASSERT_TRUE(served) << "BROAD recording " << other;
    const PredictionGain gain = compare_predictions(*served, d->model_motion, d->model_after);
    RecordProperty("nats", std::to_string(gain.before - gain.after));
    EXPECT_GT(gain.before - gain.after, 100.0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Broad, RealDiagnosis,
    testing::Values(
        Known{"02", {expect_a_lag, expect_the_hand}, "07"},
        Known{"03", {expect_a_lag, expect_the_hand, expect_a_slower_clock}},
        Known{"07", {expect_a_lag, expect_the_hand, expect_a_slower_clock}, "21"},
        Known{"11", {expect_the_hand}}, Known{"21", {expect_the_hand}},
        Known{"24", {expect_the_taps, expect_a_slower_clock}},
        Known{"29", {expect_the_stationary_magnet}},
        Known{"33", {expect_the_attached_magnet_and_when_it_was_removed, expect_a_slower_clock}}),
    [](const auto& test) { return std::string(test.param.number); });

}  // namespace
}  // namespace magimu
