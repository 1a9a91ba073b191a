// SPDX-License-Identifier: BSD-3-Clause
// The sizes of hidden effects against what they mean: a parameter over the standard deviation with
// which a fit can know it.
#include "bench/power/effect_sizes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/calibrate.h"

namespace magimu {
namespace {

HiddenCase a_case(const std::string& effect, oracle::MotionKind kind) {
  HiddenCase c = draw_case(effect, 3);
  c.options.motion.kind = kind;
  c.options.motion.duration_s = 60.0;
  c.options.rate_hz = 50.0;
  c.options.mag_rate_hz = 0.0;
  return c;
}

CalibrationOptions known_noise(const HiddenCase& c) {
  CalibrationOptions options;
  options.noise = NoiseDensities{c.options.noise.acc, c.options.noise.gyr, c.options.noise.mag};
  options.motion = c.moved() ? MotionModel::kHandHeld : MotionModel::kRotation;
  options.gyr_matrix = false;
  return options;
}

class SizeOfALag : public testing::TestWithParam<oracle::MotionKind> {};

TEST_P(SizeOfALag, is_its_value_over_its_sigma) {
  const HiddenCase c = with_sizes(a_case("mag_time_offset", GetParam()), {30.0}).front();
  EXPECT_NEAR(c.sizes.front(), 30.0, 1e-9);
  CalibrationOptions options = known_noise(c);
  options.mag_time_offset = true;
  const Calibration fitted = calibrate(oracle::simulate(c.options).recording, options);
  const ActiveEffect::Parameter& lag = fitted.effects.front().parameters.front();
  // The calibration does not know that the accelerometer has no lag of its own: a tenth of sigma.
  EXPECT_LT(c.options.effects.front()[0] / lag.sigma_model, 31.0);
  EXPECT_GT(c.options.effects.front()[0] / lag.sigma_model, 26.0);
  EXPECT_NEAR(lag.value / lag.sigma_model, 30.0, 6.0);
}

INSTANTIATE_TEST_SUITE_P(Motions, SizeOfALag,
                         testing::Values(oracle::MotionKind::kRotation,
                                         oracle::MotionKind::kHandHeld),
                         [](const auto& kind) { return oracle::to_string(kind.param); });

TEST(EffectSize, of_what_is_proportional_grows_with_its_strength) {
  const std::vector<HiddenCase> cases =
      with_sizes(a_case("mag_nonlinearity", oracle::MotionKind::kRotation), {10.0, 40.0});
  const VectorXd &small = cases[0].options.effects.front().parameters,
                 &large = cases[1].options.effects.front().parameters;
  EXPECT_LT((large - 4.0 * small).norm(), 1e-12 * large.norm());
  EXPECT_NEAR(measured(cases[1]).sizes.front(), 40.0, 1.0);
}

TEST(EffectSize, of_noise_follows_from_the_number_of_samples) {
  HiddenCase c = a_case("noise_scale", oracle::MotionKind::kRotation);
  c.options.effects = {oracle::make_effect("noise_scale", {1.01})};
  const double samples = 50.0 * 60.0;
  // 1 % in sigma is known to 1 in sqrt(2 x 3 samples).
  EXPECT_NEAR(measured(c).sizes.front(), 0.01 * std::sqrt(6.0 * samples), 0.02);
  c.options.effects = {oracle::make_effect("correlated_noise", {0.02})};
  EXPECT_NEAR(measured(c).sizes.front(), 0.02 * std::sqrt(3.0 * samples), 0.01);
}

TEST(EffectSize, is_reached_where_it_is_not_proportional_to_the_strength) {
  for (const char* effect : {"outliers", "mag_quantization", "mag_saturation"}) {
    const HiddenCase c = with_sizes(a_case(effect, oracle::MotionKind::kRotation), {12.0}).front();
    EXPECT_NEAR(c.sizes.front(), 12.0, 0.6) << effect;
    EXPECT_NEAR(measured(c).sizes.front(), c.sizes.front(), 1e-6) << effect;
  }
}

}  // namespace
}  // namespace magimu
