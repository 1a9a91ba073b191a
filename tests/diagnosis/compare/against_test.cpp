// SPDX-License-Identifier: BSD-3-Clause
// A stored calibration against another recording of the same device: nothing, or what was done to
// the device, is said to have changed.
#include "diagnosis/compare/against.h"

#include <gmock/gmock.h>

#include "calibration/result/calibration_json.h"
#include "diagnosis/compare/change_text.h"
#include "diagnosis/result/diagnosis.h"
#include "recording/data/error.h"
#include "recording/read.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

using testing::HasSubstr;

oracle::Options first_options(std::uint64_t seed) {
  oracle::Options o;
  o.seed = seed;
  o.rate_hz = 50.0;
  o.motion.duration_s = 80.0;
  o.device_kind = seed % 2 == 0 ? oracle::DeviceKind::kBoard : oracle::DeviceKind::kTableI;
  o.noise = seed % 3 == 0 ? oracle::kTableIDensities : oracle::kRealisticDensities;
  return o;
}

// Stored in a file and read back.
Calibration stored(const oracle::Options& o) {
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;
  const Calibration c = calibrate(oracle::simulate(o).recording, options);
  return calibration_from_json(nlohmann::ordered_json::parse(to_json(c).dump()), "cal.json");
}

// Another recording of the device, to which `change` was done.
Against after(
    const oracle::Options& first,
    const std::function<void(oracle::Device&)>& change = [](oracle::Device&) {}) {
  oracle::Options o = first;
  o.seed = first.seed + 1000;
  o.device = oracle::simulate(first).truth.device;
  change(*o.device);
  const Recording recording = oracle::simulate(o).recording;
  return compare_with(stored(first), "cal.json", {&recording});
}

const Change& group(const Against& a, const std::string& name) {
  for (const Change& c : a.groups) {
    if (c.group == name) return c;
  }
  throw std::invalid_argument(name);
}

std::string changed_groups(const Against& a) {
  std::string out;
  for (const Change& c : a.groups) {
    if (c.changed) out += (out.empty() ? "" : ", ") + c.group;
  }
  return out;
}

void expect_sizes(const Change& c, const std::vector<double>& truth) {
  ASSERT_EQ(c.parameters.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(c.parameters[i].value, truth[i], 4.0 * c.parameters[i].sigma) << c.sentence;
  }
}

TEST(Against, an_unchanged_device_has_not_changed) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Against a = after(first_options(seed));
    EXPECT_TRUE(a.tested);
    EXPECT_EQ(a.groups.size(), 7u);
    alarms += a.changed();
    EXPECT_THAT(a.groups.front().sentence,
                testing::AllOf(HasSubstr("no change larger than"), HasSubstr("; seen x ")));
  }
  EXPECT_LE(alarms, 1);  // of 20, at one in a hundred
}

TEST(Against, says_each_component_with_its_name_and_standard_deviation) {
  Change c{.group = "soft_iron", .changed = true, .unit = "%"};
  c.parameters = {{"xx", 0.12, 0.1, "%"}, {"xy", 1.64, 0.31, "%"}};
  EXPECT_THAT(change_sentence(c), HasSubstr("changed by xx 0.12 +- 0.10, xy 1.64 +- 0.31 %: iron"));
  c = {.group = "gyroscope_bias", .smallest = 0.0213, .unit = "rad/s"};
  c.parameters = {{"gyroscope.bias[0]", 1e-4, 2e-3, "rad/s"},
                  {"gyroscope.bias[1]", 3e-4, 2e-3, "rad/s"}};
  EXPECT_EQ(change_sentence(c),
            "The gyroscope bias: no change larger than 0.021 rad/s; seen x 0.0001 +- 0.0020, y "
            "0.0003 +- 0.0020 rad/s.");
}

TEST(Against, a_magnet_attached_is_hard_iron_with_its_size) {
  const Against a =
      after(first_options(2), [](oracle::Device& d) { d.mag_bias += Vector3(4.0, -2.0, 1.0); });
  EXPECT_EQ(changed_groups(a), "hard_iron");
  expect_sizes(group(a, "hard_iron"), {4.0, -2.0, 1.0});
}

TEST(Against, iron_added_is_soft_iron) {
  Matrix3 E;
  E << 0.02, 0.01, 0.0, 0.01, -0.015, 0.005, 0.0, 0.005, -0.005;
  const Against a = after(first_options(4), [&](oracle::Device& d) {
    d.distortion = ((Matrix3::Identity() + E) * d.distortion).eval();
  });
  EXPECT_THAT(changed_groups(a), HasSubstr("soft_iron"));
  const Change& c = group(a, "soft_iron");
  // To first order: the second is a few parts in ten thousand.
  const double truth[] = {2.0, -1.5, 1.0, 0.0, 0.5};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(c.parameters[i].value, truth[i], 4.0 * c.parameters[i].sigma + 0.03);
  }
  EXPECT_FALSE(group(a, "hard_iron").changed);
  EXPECT_FALSE(group(a, "mounting").changed);
}

TEST(Against, a_turned_magnetometer_is_its_mounting) {
  const Rot3 turn = Rot3::Exp(Vector3(0.0, 0.02, -0.01));
  const Against a = after(first_options(6), [&](oracle::Device& d) {
    d.distortion = (turn.matrix() * d.distortion).eval();
  });
  EXPECT_EQ(changed_groups(a), "mounting");
  expect_sizes(group(a, "mounting"), {0.0, 0.02 / kDegree, -0.01 / kDegree});
}

TEST(Against, another_place_is_strength_and_dip) {
  const oracle::Options first = first_options(8);
  double strength = 0.0;
  const Against a = after(first, [&](oracle::Device& d) {
    strength = d.strength_uT();
    d.distortion *= 1.05;
    d.dip_rad -= 3.0 * kDegree;
  });
  EXPECT_EQ(changed_groups(a), "field_strength, dip");
  expect_sizes(group(a, "field_strength"), {0.05 * strength});
  expect_sizes(group(a, "dip"), {-3.0});
}

TEST(Against, biases_of_gyroscope_and_accelerometer_are_told_apart) {
  const Against gyr = after(first_options(10),
                            [](oracle::Device& d) { d.gyr_bias += Vector3(0.004, 0.0, -0.002); });
  EXPECT_EQ(changed_groups(gyr), "gyroscope_bias");
  expect_sizes(group(gyr, "gyroscope_bias"), {0.004, 0.0, -0.002});
  const Against acc =
      after(first_options(10), [](oracle::Device& d) { d.acc_bias += Vector3(0.1, 0.1, -0.2); });
  EXPECT_EQ(changed_groups(acc), "accelerometer_bias");
  expect_sizes(group(acc, "accelerometer_bias"), {0.1, 0.1, -0.2});
}

TEST(Against, a_calibration_that_leaves_something_open_cannot_be_compared) {
  Calibration old;
  old.undetermined = {"rotation about the vertical."};
  const Against a = compare_calibrations(old, Calibration(), 10, 0.01);
  EXPECT_FALSE(a.tested);
  EXPECT_FALSE(a.changed());
  EXPECT_THAT(a.notes.front(), HasSubstr("rotation about the vertical"));
}

// A calibration of all of it would be of no device: half of it has the magnet.
TEST(Against, a_change_within_the_recordings_is_no_sign_that_nothing_changed) {
  for (const bool was_there : {false, true}) {
    const oracle::Options first = first_options(3);
    oracle::Options o = first;
    o.seed = first.seed + 2000;
    o.device = oracle::simulate(first).truth.device;
    Recording recording = oracle::simulate(o).recording;
    VectorSeries& mag = recording.mag.front();
    for (std::size_t k = 0; k < mag.size(); ++k) {
      if ((mag.t[k] > 40.0) != was_there) mag.v[k] += Vector3(1.5, -4.0, 2.0);
    }
    DiagnosisOptions options;
    options.against = stored(first);
    options.against_name = "cal.json";
    options.motion = MotionModel::kRotation;
    const Diagnosis d = diagnose(recording, options);
    ASSERT_TRUE(d.against);
    EXPECT_THAT(d.against->within, testing::ElementsAre(HasSubstr("hard iron change")));
    // It holds on one side of the change: outside of it, or inside, as the change was found.
    EXPECT_EQ(d.against->changed(), !d.against->fits_only.empty());
    EXPECT_THAT(changed_groups(*d.against), testing::AnyOf("", "hard_iron"));
  }
}

TEST(StoredModel, has_the_stored_effects_with_their_sizes) {
  oracle::Options o = first_options(12);
  o.effects = {oracle::make_effect("mag_time_offset", {0.012})};
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;
  options.mag_time_offset = true;
  const Recording recording = oracle::simulate(o).recording;
  Calibration old = calibrate(recording, options);
  old.effects.push_back({"hard_iron_change", {}});
  DiagnosisOptions diagnosis;
  diagnosis.base = old;
  const Diagnosis d = diagnose(recording, diagnosis);
  ASSERT_EQ(d.before.effects.size(), 1u);
  EXPECT_EQ(d.before.effects[0].name, "mag_time_offset");
  const ActiveEffect::Parameter& lag = d.before.effects[0].parameters[0];
  EXPECT_NEAR(lag.value, 0.012, 4.0 * std::max(lag.sigma, lag.sigma_model));
  EXPECT_TRUE(d.findings.empty()) << d.findings.front().sentence;
  EXPECT_THAT(d.notes, testing::Contains(HasSubstr("hard_iron_change")));
}

}  // namespace
}  // namespace magimu
