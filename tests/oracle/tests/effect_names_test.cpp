// SPDX-License-Identifier: BSD-3-Clause
// What holds of every effect there is: its name, its neutral parameters, its random size, and which
// sensors it touches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "tests/oracle/sensors.h"

namespace magimu::oracle {
namespace {

std::vector<std::string> all_effects() {
  std::vector<std::string> names = catalogue_effects();
  names.insert(names.end(), later_effects().begin(), later_effects().end());
  names.insert(names.end(), outside_effects().begin(), outside_effects().end());
  names.insert(names.end(), history_effects().begin(), history_effects().end());
  return names;
}

Recording recorded(const std::vector<Effect>& effects) {
  Options options;
  options.motion.kind = MotionKind::kHandHeld;
  options.motion.duration_s = 30.0;
  options.effects = effects;
  return simulate(options).recording;
}

TEST(EffectNames, are_those_of_the_contract) {
  EXPECT_THAT(
      catalogue_effects(),
      testing::ElementsAre(
          "acc_scale_misalignment", "gyro_scale_misalignment", "clock_scale", "gyro_g_sensitivity",
          "gyro_nonlinearity", "gyro_bias_drift", "gyro_temperature", "acc_temperature",
          "mag_temperature", "lever_arm", "mag_time_offset", "mag_lag", "mag_eddy_current",
          "field_drift", "hard_iron_drift", "hard_iron_change", "field_gradient",
          "stationary_source", "mag_nonlinearity", "mag_current", "mains_interference",
          "noise_scale", "correlated_noise", "outliers", "mag_quantization", "mag_saturation"));
  EXPECT_THAT(later_effects(),
              testing::ElementsAre(
                  "acc_time_offset", "gravity", "mag_own_clock", "mag_change", "gyro_change",
                  "acc_change", "mag_axis_time_offset", "acc_bias_drift", "acc_bias_change",
                  "gyro_bias_change", "mag_bandwidth", "acc_bandwidth", "mag_gain_drift",
                  "gyro_gain_drift", "acc_gain_drift", "acc_nonlinearity", "field_change"));
  EXPECT_GE(outside_effects().size(), 6u);
  EXPECT_GE(history_effects().size(), 9u);
  for (const std::string& name : all_effects()) EXPECT_EQ(neutral_effect(name).name(), name);
}

TEST(EffectNames, that_do_not_exist_are_refused_and_so_are_wrong_counts) {
  EXPECT_THROW(neutral_effect("gremlins"), std::invalid_argument);
  EXPECT_THROW(random_effect("linear_acceleration", 1), std::invalid_argument);
  EXPECT_THROW(make_effect("lever_arm", {1.0, 2.0}), std::invalid_argument);
  EXPECT_THROW(make_effect("field_drift", {1.0, 2.0}), std::invalid_argument);
  EXPECT_NO_THROW(make_effect("field_drift", {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}));
}

TEST(Effects, neutral_parameters_change_no_bit) {
  const Recording plain = recorded({});
  for (const std::string& name : all_effects()) {
    for (const Channel channel : {Channel::kAcc, Channel::kGyr, Channel::kMag}) {
      const Recording with = recorded({neutral_effect(name, channel)});
      EXPECT_EQ(with.acc.v, plain.acc.v) << name;
      EXPECT_EQ(with.gyr.v, plain.gyr.v) << name;
      EXPECT_EQ(with.mag[0].v, plain.mag[0].v) << name;
      EXPECT_EQ(with.mag[0].t, plain.mag[0].t) << name;
    }
  }
}

TEST(Effects, of_random_size_touch_their_own_sensor_and_no_other) {
  const Recording plain = recorded({});
  for (const std::string& name : all_effects()) {
    EffectScale scale;
    scale.duration_s = 30.0;
    const Effect effect = random_effect(name, 5, scale);
    const Recording with = recorded({effect});
    const bool clock = name == "clock_scale";
    const bool acc = clock || name.starts_with("acc_") || name == "lever_arm" || name == "gravity";
    const bool gyr = clock || name.starts_with("gyro_");
    EXPECT_EQ(with.acc.v != plain.acc.v, acc) << name;
    EXPECT_EQ(with.gyr.v != plain.gyr.v, gyr) << name;
    EXPECT_EQ(with.mag[0].v != plain.mag[0].v, clock || !(acc || gyr)) << name;
  }
}

TEST(Effects, with_a_channel_touch_that_sensor) {
  const Recording plain = recorded({});
  for (const char* name : {"noise_scale", "correlated_noise", "outliers", "sample_repetition"}) {
    for (const Channel channel : {Channel::kAcc, Channel::kGyr, Channel::kMag}) {
      EffectScale scale;
      scale.channel = channel;
      const Recording with = recorded({random_effect(name, 5, scale)});
      EXPECT_EQ(with.acc.v != plain.acc.v, channel == Channel::kAcc) << name;
      EXPECT_EQ(with.gyr.v != plain.gyr.v, channel == Channel::kGyr) << name;
      EXPECT_EQ(with.mag[0].v != plain.mag[0].v, channel == Channel::kMag) << name;
    }
  }
}

TEST(RandomEffect, is_named_by_its_seed_and_grows_with_its_strength) {
  EffectScale twice;
  twice.strength = 2.0;
  for (const std::string& name : all_effects()) {
    const Effect a = random_effect(name, 7), b = random_effect(name, 7), c = random_effect(name, 8);
    EXPECT_EQ(a.parameters, b.parameters) << name;
    EXPECT_NE(a.parameters, c.parameters) << name;
    EXPECT_NE(a.parameters, random_effect(name, 7, twice).parameters) << name;
  }
  const Effect once = random_effect("gyro_g_sensitivity", 7);
  const Effect more = random_effect("gyro_g_sensitivity", 7, twice);
  EXPECT_EQ(more.parameters, 2.0 * once.parameters);
}

}  // namespace
}  // namespace magimu::oracle
