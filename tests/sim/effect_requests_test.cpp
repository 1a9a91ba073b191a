// SPDX-License-Identifier: BSD-3-Clause
// What --effect understands, and the sizes it draws.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "recording/data/error.h"
#include "sim/hidden_effects.h"

namespace magimu {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

HiddenEffect hidden(const std::string& text, std::uint64_t seed = 1) {
  return hide(parse_effect_request(text), {seed, 60.0, 27.0});
}
std::vector<double> values(const HiddenEffect& effect) {
  std::vector<double> out;
  for (const auto& p : effect.parameters) out.push_back(p.value);
  return out;
}
// The message of the error.
std::string refusal(const std::string& text) {
  try {
    hidden(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(EffectRequest, takes_explicit_parameters_in_order) {
  EXPECT_EQ(values(hidden("lever_arm=0.05:-1e-2:+0.02")), (std::vector<double>{0.05, -0.01, 0.02}));
  EXPECT_EQ(values(hidden("mag_lag=0.012:")), std::vector<double>{0.012});
  EXPECT_EQ(values(hidden("hard_iron_change=1:2:3:-inf:20")),
            (std::vector<double>{1, 2, 3, -kInfinity, 20}));
  EXPECT_EQ(values(hidden("field_drift=1:2:3:4:5:6:7:8:9")).size(), 9u);
  const HiddenEffect mains = hidden("mains_interference=1:2:3:4:5:6:49.9");
  EXPECT_EQ(mains.parameters.back().name, "f");
  EXPECT_EQ(mains.parameters.back().unit, "Hz");
}

TEST(EffectRequest, names_the_sensor_whose_noise_is_changed) {
  EXPECT_EQ(hidden("noise_scale").channel, Sensor::kMag);
  EXPECT_EQ(hidden("noise_scale@acc=2:").channel, Sensor::kAcc);
  EXPECT_EQ(values(hidden("outliers@gyr=0.01:20")), (std::vector<double>{0.01, 20.0}));
}

TEST(EffectRequest, is_refused_with_a_remedy) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal("gremlins"),
              HasSubstr("known are acc_bandwidth, acc_bias_change, acc_bias_drift"));
  EXPECT_THAT(refusal("lever_arm=1:2"), HasSubstr("r[0] (m), r[1] (m), r[2] (m)"));
  EXPECT_THAT(refusal("hard_iron_change=1:2:3"), HasSubstr("t0 (s), t1 (s)"));
  EXPECT_THAT(refusal("field_drift=1:2"), HasSubstr("three for each term"));
  EXPECT_THAT(refusal("lever_arm=much"), HasSubstr("is no number"));
  EXPECT_THAT(refusal("lever_arm=1:nan:2"), HasSubstr("is no number"));
  EXPECT_THAT(refusal("lever_arm=1:inf:2"), HasSubstr("finite"));
  EXPECT_THAT(refusal("mag_lag=-0.01:"), HasSubstr("above 0 s"));
  EXPECT_THAT(refusal("correlated_noise=1:"), HasSubstr("between -1 and 1"));
  EXPECT_THAT(refusal("noise_scale@ear"), HasSubstr("@acc, @gyr or @mag"));
  for (const char* text : {"lever_arm@mag", "mag_quantization@acc"}) {
    EXPECT_THAT(refusal(text), HasSubstr("leave the @ out")) << text;
  }
}

TEST(RealisticSize, is_named_by_the_seed_and_grows_with_the_factor) {
  for (const std::string& name : hidden_effect_names()) {
    EXPECT_EQ(values(hidden(name, 3)), values(hidden(name, 3))) << name;
    EXPECT_NE(values(hidden(name, 3)), values(hidden(name, 4))) << name;
    EXPECT_NE(values(hidden(name, 3)), values(hidden(name + "=2", 3))) << name;
  }
  const HiddenEffect once = hidden("mag_eddy_current", 3), twice = hidden("mag_eddy_current=2", 3);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_DOUBLE_EQ(twice[i], 2.0 * once[i]);
}

TEST(RealisticSize, lies_within_what_a_fit_expects) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    for (const auto& effect : effect_catalogue()) {
      if (effect->name() == "gyro_bias_drift" || effect->name() == "stationary_source" ||
          effect->name() == "mag_own_clock") {
        continue;
      }
      const HiddenEffect h = hidden(effect->name(), seed);
      for (int i = 0; i < std::min(effect->size(), int(h.parameters.size())); ++i) {
        const auto& p = effect->description().parameters[std::size_t(i)];
        EXPECT_EQ(h.parameters[std::size_t(i)].name, p.name);
        EXPECT_LE(std::abs(h[std::size_t(i)]), 0.3 * p.prior_sigma) << effect->name();
        EXPECT_GE(std::abs(h[std::size_t(i)]), 0.1 * p.prior_sigma) << effect->name();
      }
    }
    EXPECT_GT(hidden("mag_lag", seed)[0], 0.0);
    EXPECT_GE(hidden("mag_own_clock", seed)[0], 0.003);
    const HiddenEffect change = hidden("hard_iron_change", seed);
    EXPECT_LT(change[3], change[4]);
    EXPECT_LT(change[3], 60.0);
  }
}

}  // namespace
}  // namespace magimu
