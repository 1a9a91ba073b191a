// SPDX-License-Identifier: BSD-3-Clause
// Effects that begin or end in mid-recording, times, gravity and clocks: each is hidden by the
// oracle and must be named, with its size and times, and must not be named where its neighbour is
// hidden.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "bench/power/judge_diagnosis.h"
#include "diagnosis/noise/own_clock.h"

namespace magimu {
namespace {

using oracle::make_effect;

constexpr double kForGood = std::numeric_limits<double>::infinity();

struct Hidden {
  std::string as;  // of the test
  oracle::Effect effect;
  std::string named;                // empty: nothing in particular
  std::vector<std::string> others;  // not to be named
  oracle::MotionKind motion = oracle::MotionKind::kRotation;
};

std::vector<double> gains(double k, double t0, double t1 = kForGood) {
  return {k, 0, 0, 0, 0, 0, 0, 0, 0, t0, t1};
}

// Readings that are turned so, rad.
std::vector<double> turned(const Vector3& phi, double t0, double t1) {
  const Matrix3 C = Rot3::Exp(phi).matrix() - Matrix3::Identity();
  return {C(0, 0), C(0, 1), C(0, 2), C(1, 0), C(1, 1), C(1, 2), C(2, 0), C(2, 1), C(2, 2), t0, t1};
}

std::vector<Hidden> all_hidden() {
  const std::vector<std::string> changes = {"mag_change", "gyro_change", "acc_change",
                                            "hard_iron_change", "field_change"};
  const auto with = [](std::vector<std::string> names, const char* another) {
    names.emplace_back(another);
    return names;
  };
  const auto changes_but = [&](const std::string& own) {
    std::vector<std::string> out = changes;
    std::erase(out, own);
    return out;
  };
  return {
      {"mag_gain",
       make_effect("mag_change", gains(0.01, 41.3)),
       "mag_change",
       {"gyro_change", "acc_change", "hard_iron_change", "field_drift", "hard_iron_drift"}},
      {"mag_gain_for_a_while", make_effect("mag_change", gains(0.02, 25.2, 52.7)), "mag_change",
       changes_but("mag_change")},
      {"mag_board_turns", make_effect("mag_board_turn", {0.01, -0.02, 0.01, 40.0, kForGood}),
       "mag_change", changes_but("mag_change")},
      {"gyro_gain", make_effect("gyro_change", gains(0.02, 44.0)), "gyro_change",
       changes_but("gyro_change")},
      {"acc_gain", make_effect("acc_change", gains(0.02, 38.0)), "acc_change",
       changes_but("acc_change")},
      // What large gains of any sensor leave to the accelerometer looks like a hand.
      {"gyro_gains_of_a_turned_sensor",
       make_effect("gyro_change",
                   {0.02, -0.015, 0.03, 0.01, -0.02, 0.01, -0.02, 0.03, 0.015, 44.0, kForGood}),
       "gyro_change",
       with(with(changes_but("gyro_change"), "linear_acceleration"), "gyro_bias_change")},
      {"acc_gains_of_a_turned_sensor",
       make_effect("acc_change",
                   {0.01, -0.008, 0.015, 0.005, -0.01, 0.005, -0.01, 0.015, 0.008, 38.0, kForGood}),
       "acc_change",
       with(with(changes_but("acc_change"), "linear_acceleration"), "acc_gain_drift")},
      // By 2 degrees: magnetometer and accelerometer that turn at the same moment the other way.
      {"gyro_that_sat_askew",
       make_effect("gyro_change", turned({0.0164, 0.0284, 0.012}, -kForGood, 51.2)), "gyro_change",
       with(changes_but("gyro_change"), "gyro_scale_misalignment"), oracle::MotionKind::kHandHeld},
      // All the time: no change whose time is hardly told.
      {"gyro_gains_throughout",
       make_effect("gyro_scale_misalignment", {0.0066, 0, 0, 0, 0.0114, 0, 0, 0, -0.0055}),
       "gyro_scale_misalignment", changes, oracle::MotionKind::kHandHeld},
      {"gyro_askew_throughout",
       make_effect("gyro_scale_misalignment",
                   {0, 0.001, -0.006, -0.001, 0, 0.001, 0.006, -0.001, 0}),
       "gyro_scale_misalignment", changes, oracle::MotionKind::kHandHeld},
      {"acc_bias", make_effect("acc_bias_change", {0.04, -0.03, 0.05, 38.0, kForGood}),
       "acc_bias_change", with(changes, "acc_bias_drift")},
      {"acc_bias_moved", make_effect("acc_bias_change", {0.04, -0.03, 0.05, 38.0, kForGood}),
       "acc_bias_change", with(changes, "acc_bias_drift"), oracle::MotionKind::kHandHeld},
      {"acc_warms_up", make_effect("acc_bias_drift", {0.02, 0.03, -0.02}), "acc_bias_drift",
       changes},
      {"acc_warms_up_moved", make_effect("acc_bias_drift", {0.02, 0.03, -0.02}), "acc_bias_drift",
       changes, oracle::MotionKind::kHandHeld},
      {"gyro_bias", make_effect("gyro_bias_change", {0.004, -0.003, 0.005, 44.0, kForGood}),
       "gyro_bias_change", with(changes, "gyro_bias_drift")},
      {"hard_iron", make_effect("hard_iron_change", {1.0, -0.5, 0.8, 43.0, kForGood}),
       "hard_iron_change", changes_but("hard_iron_change")},
      {"field_drift", make_effect("field_drift", {0.01, 0.02, -0.01}), "field_drift", changes},
      {"field", make_effect("field_change", {0.06, -0.04, 0.06, 41.3, kForGood}), "field_change",
       with(changes_but("field_change"), "field_drift")},
      {"field_for_a_while", make_effect("field_change", {0.02, 0.01, -0.03, 31.2, 47.7}),
       "field_change", with(changes_but("field_change"), "field_drift")},
      {"field_moved", make_effect("field_change", {0.06, -0.04, 0.06, 41.3, kForGood}),
       "field_change", with(changes_but("field_change"), "field_drift"),
       oracle::MotionKind::kHandHeld},
      {"mag_gains_drift", make_effect("mag_gain_drift", {0.02, -0.01, 0.005}), "mag_gain_drift",
       with(changes, "field_drift")},
      {"gyro_gains_drift", make_effect("gyro_gain_drift", {0.02, -0.02, 0.01}), "gyro_gain_drift",
       changes},
      {"acc_gains_drift", make_effect("acc_gain_drift", {0.0, 0.0, 0.0, 0.01, -0.02, 0.02}),
       "acc_gain_drift", changes},
      {"acc_gains_drift_moved", make_effect("acc_gain_drift", {0.02, 0.01, 0.02, 0.02, 0.01, 0.02}),
       "acc_gain_drift", changes, oracle::MotionKind::kHandHeld},
      {"mag_filter",
       make_effect("mag_bandwidth", {0.002}),
       "mag_bandwidth",
       {"mag_time_offset", "mag_lag", "mag_own_clock", "mag_nonlinearity"}},
      {"acc_filter",
       make_effect("acc_bandwidth", {0.002}),
       "acc_bandwidth",
       {"gravity", "acc_time_offset", "acc_scale_misalignment"}},
      {"acc_filter_moved",
       make_effect("acc_bandwidth", {0.0004}),
       "acc_bandwidth",
       {"gravity", "acc_time_offset", "acc_scale_misalignment"},
       oracle::MotionKind::kHandHeld},
      {"acc_bends", make_effect("acc_nonlinearity", {0.01, -0.006, 0.008}), "acc_nonlinearity",
       with(changes, "gravity")},
      {"acc_bends_moved", make_effect("acc_nonlinearity", {0.01, 0.01, 0.01}), "acc_nonlinearity",
       with(changes, "gravity"), oracle::MotionKind::kHandHeld},
      {"acc_offset",
       make_effect("acc_time_offset", {0.006}),
       "acc_time_offset",
       {"mag_time_offset", "mag_lag", "mag_own_clock"}},
      {"acc_offset_moved",
       make_effect("acc_time_offset", {0.006}),
       "acc_time_offset",
       {"mag_time_offset", "mag_lag"},
       oracle::MotionKind::kHandHeld},
      {"mag_offset",
       make_effect("mag_time_offset", {0.008}),
       "mag_time_offset",
       {"acc_time_offset", "mag_own_clock"}},
      {"mag_axes",
       make_effect("mag_axis_time_offset", {0.001, 0.004, 0.007}),
       "mag_axis_time_offset",
       {"mag_time_offset", "mag_lag", "mag_eddy_current", "mag_own_clock"}},
      {"gravity", make_effect("gravity", {0.02}), "gravity", {"acc_scale_misalignment"}},
      {"gravity_moved",
       make_effect("gravity", {0.02}),
       "gravity",
       {"acc_scale_misalignment"},
       oracle::MotionKind::kHandHeld},
      {"acc_scale",
       make_effect("acc_scale_misalignment", {0.01, 0.004, -0.008, 0.003, 0.005, 0.0}),
       "acc_scale_misalignment",
       {"gravity", "acc_change"}},
      {"own_clock",
       make_effect("mag_own_clock", {0.0066, 0.3}),
       "mag_own_clock",
       {"mag_time_offset", "mag_lag", "mains_interference"}},
      // Half a percent slower than it is read: a pattern of two seconds.
      {"own_clock_of_the_same_rate",
       make_effect("mag_own_clock", {0.01005, 0.3}),
       "mag_own_clock",
       {"mag_time_offset", "mag_lag", "outliers", "mag_change", "correlated_noise"}},
      {"own_clock_of_the_same_rate_moved",
       make_effect("mag_own_clock", {0.00996, 0.7}),
       "mag_own_clock",
       {"mag_time_offset", "mag_lag", "outliers", "mag_change", "correlated_noise"},
       oracle::MotionKind::kHandHeld},
      {"mains",
       make_effect("mains_interference", {0.3, -0.2, 0.2, 0.1, 0.3, 0.2, 49.7}),
       "",
       {"mag_own_clock"}},
      {"quantization", make_effect("mag_quantization", {0.3}), "", {"mag_own_clock"}},
  };
}

class LaterEffect : public testing::TestWithParam<Hidden> {};

TEST_P(LaterEffect, is_named_and_its_neighbours_are_not) {
  const Hidden& hidden = GetParam();
  HiddenCase c;
  c.options.seed = 11;
  c.options.motion.kind = hidden.motion;
  c.options.motion.duration_s = 80.0;
  c.options.noise = oracle::kRealisticDensities;
  c.options.effects = {hidden.effect};
  const Diagnosis d = diagnose(oracle::simulate(c.options).recording, diagnosis_options(c));
  for (const std::string& other : hidden.others) {
    EXPECT_EQ(find(d, other), nullptr) << "named: " << names_of(d);
  }
  if (hidden.named.empty()) return;
  EXPECT_NE(d.answer, Answer::kPredicts);
  const Finding* f = find(d, hidden.named);
  ASSERT_NE(f, nullptr) << "named: " << names_of(d);
  EXPECT_GT(f->gain.heldout_nll_before - f->gain.heldout_nll_after, 1.0);
  if (hidden.effect.name() == hidden.named) {
    EXPECT_LT(farthest_sigma(*f, hidden.effect, c.options), 4.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Oracle, LaterEffect, testing::ValuesIn(all_hidden()),
                         [](const auto& test) { return test.param.as; });

void expect_time(const Finding& f, const char* name, double t) {
  const auto at = std::ranges::find(f.parameters, name, &FoundParameter::name);
  ASSERT_NE(at, f.parameters.end());
  EXPECT_NEAR(at->value, t, 4.0 * std::max(at->sigma, 0.02)) << name << " of " << f.effect;
}

// As where a set and a reset are exchanged. A field that is turned round reads the same, but no
// place has one; and a search in which each of the two makes the other one needless must end.
TEST(Changes, a_magnetometer_that_changes_its_sign_for_a_while_is_no_change_of_the_field) {
  HiddenCase c;
  c.options.seed = 11;
  c.options.motion.kind = oracle::MotionKind::kHandHeld;
  c.options.motion.duration_s = 80.0;
  c.options.noise = oracle::kRealisticDensities;
  c.options.effects = {make_effect("mag_change", {-2, 0, 0, 0, -2, 0, 0, 0, -2, 35.4, 40.8})};
  const Diagnosis d = diagnose(oracle::simulate(c.options).recording, diagnosis_options(c));
  EXPECT_EQ(find(d, "field_change"), nullptr) << "named: " << names_of(d);
  const Finding* change = find(d, "mag_change");
  ASSERT_NE(change, nullptr) << "named: " << names_of(d);
  expect_time(*change, "t0", 35.4);
  expect_time(*change, "t1", 40.8);
}

// A chip that turns on its board by 3 degrees, of a device with 30 uT of hard iron: what turns with
// it reads otherwise, what does not is a bias that changes with the turn.
TEST(Changes, a_chip_that_turns_and_leaves_its_bias_behind_is_found) {
  oracle::Options o;
  o.seed = 41;
  o.motion.duration_s = 80.0;
  o.noise = oracle::kRealisticDensities;
  const double t0 = 41.3;
  const Vector3 turn(0.03, -0.03, 0.02), bias(20.0, -15.0, 12.0);
  const Vector3 left = bias - Rot3::Exp(turn) * bias;
  o.effects = {make_effect("mag_board_turn", {turn[0], turn[1], turn[2], t0, kForGood}),
               make_effect("hard_iron_change", {left[0], left[1], left[2], t0, kForGood})};
  DiagnosisOptions options;
  options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
  const Diagnosis d = diagnose(oracle::simulate(o).recording, options);
  const Finding* f = find(d, "mag_change");
  ASSERT_NE(f, nullptr) << "named: " << names_of(d);
  EXPECT_EQ(find(d, "hard_iron_change"), nullptr) << "named: " << names_of(d);
  EXPECT_EQ(find(d, "gyro_change"), nullptr) << "named: " << names_of(d);
  expect_time(*f, "t0", t0);
}

// A hand that moves the sensor for a minute.
oracle::Options hand_held(std::uint64_t seed) {
  oracle::Options o;
  o.seed = seed;
  o.motion.kind = oracle::MotionKind::kHandHeld;
  o.motion.duration_s = 60.0;
  o.noise = oracle::kRealisticDensities;
  return o;
}

DiagnosisOptions with_noise_of(const oracle::Options& o) {
  DiagnosisOptions options;
  options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
  return options;
}

Diagnosis diagnose_hidden(const oracle::Options& o) {
  return diagnose(oracle::simulate(o).recording, with_noise_of(o));
}

// Windows of some seconds tell an end near to the recording's hardly from none.
TEST(Changes, that_begin_and_end_are_found_with_both_times) {
  oracle::Options o = hand_held(43);
  o.effects = {make_effect("gyro_change", {0.03, 0, 0, 0, -0.02, 0, 0, 0, 0.03, 26.4, 52.3})};
  const Diagnosis d = diagnose_hidden(o);
  const Finding* f = find(d, "gyro_change");
  ASSERT_NE(f, nullptr) << "named: " << names_of(d);
  expect_time(*f, "t0", 26.4);
  expect_time(*f, "t1", 52.3);
  EXPECT_EQ(find(d, "mag_change"), nullptr) << "named: " << names_of(d);
}

// Beside either alone what is left scatters as coloured noise does.
TEST(Changes, that_hide_an_error_of_the_gyroscope_are_found_with_it) {
  oracle::Options o = hand_held(44);
  o.effects = {make_effect("mag_change", {-0.003, 0.022, 0.027, 0.024, 0.016, -0.03, 0.025, 0.049,
                                          -0.007, 18.9, 45.1}),
               make_effect("gyro_scale_misalignment",
                           {0.005, -0.001, -0.003, 0.0005, 0.017, 0.009, -0.002, -0.004, 0.0003})};
  const Diagnosis d = diagnose_hidden(o);
  const Finding* change = find(d, "mag_change");
  ASSERT_NE(change, nullptr) << "named: " << names_of(d);
  EXPECT_NE(find(d, "gyro_scale_misalignment"), nullptr) << "named: " << names_of(d);
  expect_time(*change, "t0", 18.9);
  expect_time(*change, "t1", 45.1);
}

// By one step "depends on time" explains more of a large drift than a fit with the drift does, and
// a slow process explains as much: neither is a reason not to name it.
class LargeDrift : public testing::TestWithParam<oracle::MotionKind> {};

TEST_P(LargeDrift, is_named) {
  oracle::Options o;
  o.seed = 45;
  o.motion.kind = GetParam();
  o.motion.duration_s = 100.0;
  o.noise = oracle::kRealisticDensities;
  o.effects = {make_effect("acc_bias_drift", {-0.8, 0.6, -0.04, -0.3, -0.04, 0.7})};
  const Diagnosis d = diagnose_hidden(o);
  EXPECT_NE(find(d, "acc_bias_drift"), nullptr) << "named: " << names_of(d);
}

INSTANTIATE_TEST_SUITE_P(Oracle, LargeDrift,
                         testing::Values(oracle::MotionKind::kRotation,
                                         oracle::MotionKind::kHandHeld),
                         [](const auto& test) {
                           return test.param == oracle::MotionKind::kRotation ? "turned" : "moved";
                         });

// A gap makes parts of the recording, in one of which the current is the same all the time.
TEST(Current, that_varies_in_one_part_only_is_found_by_its_column) {
  oracle::Options o = hand_held(52);
  o.record_current = true;
  o.current = [](double t) { return t < 40.0 && long(t / 7.0) % 2 == 0 ? 2.0 : 0.5; };
  o.effects = {make_effect("mag_current", {1.2, -0.6, 0.8})};
  const Recording whole = oracle::simulate(o).recording;
  std::vector<Recording> parts = {slice(whole, 0.0, 45.0), slice(whole, 46.5, 60.0)};
  parts.back().continues_previous = true;
  const Diagnosis d = diagnose({&parts[0], &parts[1]}, with_noise_of(o));
  EXPECT_NE(find(d, "mag_current"), nullptr) << "named: " << names_of(d);
}

// What was added to the readings of a hand-held sensor, with motion that no rest interrupts.
Diagnosis diagnose_with(std::uint64_t seed, const std::function<void(Recording&)>& change) {
  const oracle::Options o = hand_held(seed);
  Recording recording = oracle::simulate(o).recording;
  change(recording);
  return diagnose(recording, with_noise_of(o));
}

void add_between(double t0, double t1, const Vector3& s, VectorSeries& series) {
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (series.t[k] >= t0 && series.t[k] < t1) series.v[k] += s;
  }
}

// Gains alone, or turns, take part of it: nothing but the bias changed.
TEST(Changes, of_the_gyroscope_s_bias_that_come_and_go_are_changes_of_its_bias) {
  const Diagnosis d = diagnose_with(
      46, [](Recording& r) { add_between(22.1, 44.6, Vector3(0.004, -0.003, 0.03), r.gyr); });
  const Finding* f = find(d, "gyro_bias_change");
  ASSERT_NE(f, nullptr) << "named: " << names_of(d);
  expect_time(*f, "t0", 22.1);
  expect_time(*f, "t1", 44.6);
  EXPECT_EQ(find(d, "gyro_change"), nullptr) << "named: " << names_of(d);
}

// What the accelerometer reads then depends on time, though the hand moves it as well.
TEST(Changes, of_the_accelerometer_s_bias_do_not_hide_the_hand_s_motion) {
  const Diagnosis d = diagnose_with(
      47, [](Recording& r) { add_between(20.3, 41.7, Vector3(2.0, 0.0, 0.0), r.acc); });
  EXPECT_NE(find(d, "linear_acceleration"), nullptr) << "named: " << names_of(d);
  EXPECT_EQ(find(d, "correlated_noise"), nullptr) << "named: " << names_of(d);
  EXPECT_TRUE(d.answer == Answer::kPartly || find(d, "acc_bias_change") != nullptr ||
              find(d, "acc_change") != nullptr)
      << "named: " << names_of(d);
}

// Ten times what parts differ by.
TEST(Changes, of_a_gain_by_half_are_found) {
  const Diagnosis d = diagnose_with(48, [](Recording& r) {
    VectorSeries& mag = r.mag.front();
    for (std::size_t k = 0; k < mag.size(); ++k) {
      if (mag.t[k] >= 24.6 && mag.t[k] < 40.2) mag.v[k].z() *= 0.5;
    }
  });
  const Finding* f = find(d, "mag_change");
  ASSERT_NE(f, nullptr) << "named: " << names_of(d);
  expect_time(*f, "t0", 24.6);
  expect_time(*f, "t1", 40.2);
  EXPECT_EQ(find(d, "mag_own_clock"), nullptr) << "named: " << names_of(d);
}

// A change of the accelerometer's gains for some time explains much of it by chance.
TEST(Changes, are_not_named_for_rates_that_leak_into_the_accelerometer) {
  const Diagnosis d = diagnose_with(49, [](Recording& r) {
    Matrix3 leak;
    leak << 0.08, -0.18, -0.11, -0.03, 0.10, -0.13, 0.21, 0.02, 0.0;
    for (std::size_t k = 0; k < r.acc.size() && k < r.gyr.size(); ++k)
      r.acc.v[k] += leak * r.gyr.v[k];
  });
  EXPECT_EQ(find(d, "acc_change"), nullptr) << "named: " << names_of(d);
  EXPECT_NE(d.answer, Answer::kPredicts);
}

// A motor's current, of which there is no column: bursts along one line of the sensor's frame.
TEST(PassingSource, bursts_along_a_line_of_the_device_are_no_magnet_that_was_passed) {
  oracle::Options o;
  o.seed = 42;
  o.motion.kind = oracle::MotionKind::kHandHeld;
  o.motion.duration_s = 80.0;
  o.noise = oracle::kRealisticDensities;
  Recording recording = oracle::simulate(o).recording;
  VectorSeries& mag = recording.mag.front();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    const double since = std::fmod(mag.t[k], 8.0);
    if (since > 5.0 && since < 6.5) mag.v[k] += Vector3(9.0, 0.0, 12.0);
  }
  DiagnosisOptions options;
  options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
  const Diagnosis d = diagnose(recording, options);
  EXPECT_EQ(find(d, "stationary_source"), nullptr) << "named: " << names_of(d);
  EXPECT_THAT(d.unexplained.evidence,
              testing::Contains(testing::HasSubstr("along one line of its own frame")));
}

struct Moved {
  Recording recording;
  oracle::Truth truth;
  DiagnosisOptions options;
};

Moved moved_by_hand(std::uint64_t seed, double fastest_rad_s) {
  oracle::Options o;
  o.seed = seed;
  o.motion.kind = oracle::MotionKind::kHandHeld;
  o.motion.duration_s = 80.0;
  o.motion.fastest_rad_s = fastest_rad_s;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.noise = oracle::kRealisticDensities;
  oracle::Simulation simulation = oracle::simulate(o);
  Moved out{std::move(simulation.recording), std::move(simulation.truth), {}};
  out.options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
  return out;
}

void expect_a_turned_field(const Diagnosis& d, const char* told) {
  EXPECT_EQ(find(d, "stationary_source"), nullptr) << "named: " << names_of(d);
  EXPECT_THAT(d.unexplained.evidence,
              testing::Contains(testing::AllOf(testing::HasSubstr("has the predicted size"),
                                               testing::HasSubstr(told))))
      << "named: " << names_of(d);
}

// An error of the attitude turns the predicted field and leaves its size.
TEST(PassingSource, a_gyroscope_that_saturates_softly_is_no_magnet_that_was_passed) {
  Moved moved = moved_by_hand(43, 4.0);
  for (Vector3& rate : moved.recording.gyr.v) {
    for (double& w : rate) w = 4.0 * std::tanh(w / 4.0);
  }
  expect_a_turned_field(diagnose(moved.recording, moved.options), "The gyroscope read up to");
}

// 40 ms late from some time on.
TEST(PassingSource, a_magnetometer_that_comes_late_is_no_magnet_that_was_passed) {
  Moved moved = moved_by_hand(44, 4.0);
  VectorSeries& mag = moved.recording.mag.front();
  const VectorSeries as_it_was = mag;
  constexpr std::size_t kLate = 4;  // samples at 100 Hz
  for (std::size_t k = kLate; k < mag.size(); ++k) {
    if (mag.t[k] > 45.0) mag.v[k] = as_it_was.v[k - kLate];
  }
  expect_a_turned_field(diagnose(moved.recording, moved.options), "ms older");
}

// Five magnets, passed within a second each.
TEST(PassingSource, magnets_that_were_passed_are_named) {
  Moved moved = moved_by_hand(45, 2.5);
  VectorSeries& mag = moved.recording.mag.front();
  std::mt19937_64 random(45);
  std::normal_distribution<double> normal;
  for (int pass = 0; pass < 5; ++pass) {
    const double at = 10.0 + 13.0 * pass;
    const Vector3 along = Vector3(normal(random), normal(random), normal(random)).normalized();
    const Vector3 moment = Vector3(normal(random), normal(random), normal(random)).normalized();
    const Vector3 beside = 0.1 * along.cross(moment).normalized();
    for (std::size_t k = 0; k < mag.size(); ++k) {
      if (std::abs(mag.t[k] - at) > 3.0) continue;
      const Vector3 away = beside + 0.2 * (mag.t[k] - at) * along;
      const double r = away.norm();
      // In n, uT: a dipole of 0.1 A m^2.
      const Vector3 field =
          0.01 / std::pow(r, 3) * (3.0 * away.dot(moment) * away / (r * r) - moment);
      const auto i = std::size_t(std::ranges::lower_bound(moved.truth.t, mag.t[k] - 1e-6) -
                                 moved.truth.t.begin());
      mag.v[k] += moved.truth.device.distortion / moved.truth.device.strength_uT() *
                  (moved.truth.nRb[i].matrix().transpose() * field);
    }
  }
  const Diagnosis d = diagnose(moved.recording, moved.options);
  EXPECT_NE(find(d, "stationary_source"), nullptr) << "named: " << names_of(d);
}

// Two recordings of one device, between which its magnetometer's gain changed.
TEST(Changes, between_two_recordings_are_found) {
  oracle::Options o;
  o.seed = 21;
  o.device_seed = 5;
  o.motion.duration_s = 50.0;
  o.noise = oracle::kRealisticDensities;
  const Recording first = oracle::simulate(o).recording;
  o.seed = 22;
  o.effects = {make_effect("mag_change", gains(0.02, -1.0))};
  const Recording second = oracle::simulate(o).recording;
  DiagnosisOptions options;
  options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
  const Diagnosis d = diagnose(std::vector<const Recording*>{&first, &second}, options);
  const Finding* f = find(d, "mag_change");
  ASSERT_NE(f, nullptr) << "named: " << names_of(d);
  const auto at = std::ranges::find(f->parameters, "recording_of_t0", &FoundParameter::name);
  ASSERT_NE(at, f->parameters.end());
  EXPECT_EQ(at->value, 2.0);
}

// Ages in a pattern, of exact and of white residuals.
SampleResiduals turning(double period_s, double share, double noise_uT, std::uint64_t seed) {
  SampleResiduals mag{.channel = Sensor::kMag};
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 12000; ++k) {
    const double t = 0.01 * k;
    const Vector3 rate(std::sin(0.7 * t), std::cos(0.5 * t), std::sin(0.3 * t + 1.0));
    const Vector3 across = rate.cross(Vector3(1.0, 0.5, -0.3));
    const double turns = period_s > 0.0 ? t / period_s + share : 0.0;
    const double age = period_s * (turns - std::floor(turns) - 0.5);
    mag.t.push_back(t);
    mag.reading.push_back(Vector3::Zero());
    mag.change.push_back(60.0 * rate);
    mag.across.push_back(60.0 * across);
    const Vector3 noise(normal(random), normal(random), normal(random));
    mag.residual.push_back(noise_uT * noise - age * mag.change.back());
  }
  return mag;
}

TEST(OwnClock, is_found_with_its_period_and_taken_out) {
  for (const double period : {0.0037, 0.0066, 0.0096}) {
    SampleResiduals mag = turning(period, 0.3, 0.3, 3);
    const auto clock = find_own_clock(mag, 1e-3);
    ASSERT_TRUE(clock) << period;
    EXPECT_NEAR(clock->period_s, period, 1e-4 * period);
    EXPECT_LT(std::abs(clock->period_s - period), 4.0 * clock->period_sigma_s);
    double before = 0.0, after = 0.0;
    for (const Vector3& r : mag.residual) before += r.squaredNorm() / 36000.0;
    take_out_own_clock(clock->period_s, clock->share, mag);
    for (const Vector3& r : mag.residual) after += r.squaredNorm() / 36000.0;
    EXPECT_NEAR(after, 0.09, 0.004) << period << " of " << before;
  }
}

TEST(OwnClock, is_not_found_in_white_noise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_FALSE(find_own_clock(turning(0.0, 0.0, 0.3, seed), 1e-3)) << seed;
  }
}

}  // namespace
}  // namespace magimu
