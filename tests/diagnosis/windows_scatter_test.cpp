// SPDX-License-Identifier: BSD-3-Clause
// The scatter of windows' scores at the optimum is 1 under white noise, however much of it the fit
// has followed: with nine parameters in twelve windows, and with more parameters than windows.
#include <gtest/gtest.h>

#include "bench/hidden_cases.h"
#include "calibration/pipeline.h"
#include "calibration/scan.h"
#include "factors/effects/catalogue.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

Score tested(std::uint64_t seed, NoiseKind noise, const std::shared_ptr<const Effect>& effect) {
  HiddenCase c = draw_none(noise, seed);
  c.options.motion.kind = oracle::MotionKind::kRotation;
  c.options.motion.duration_s = 60.0;
  c.options.rate_hz = 50.0;
  c.options.mag_rate_hz = 0.0;
  const Recording recording = oracle::simulate(c.options).recording;
  const std::vector<const Recording*> recordings = {&recording};
  CalibrationOptions options;
  options.noise = NoiseDensities{c.options.noise.acc, c.options.noise.gyr, c.options.noise.mag};
  const Pipeline pipeline(recordings, options);
  const Stage stage = pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kRotation));
  ModelSpec spec = stage.spec();
  spec.effects.push_back(effect);
  return wald_test(pipeline.refit_with_same_noise(stage, spec), 0);
}

TEST(WindowsScatter, is_one_under_white_noise) {
  for (const auto& effect :
       {find_effect("gyro_scale_misalignment"), make_gyro_bias_walk(16, 1e-4)}) {
    double sum = 0.0;
    int coloured = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Score s = tested(seed, NoiseKind::kWhite, effect);
      sum += s.scatter / 10.0;
      coloured += s.coloured ? 1 : 0;
    }
    EXPECT_NEAR(sum, 1.0, 0.12) << effect->name();
    EXPECT_LE(coloured, 2) << effect->name();
  }
}

TEST(WindowsScatter, is_large_under_coloured_noise) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Score s = tested(seed, NoiseKind::kColoured, find_effect("gyro_scale_misalignment"));
    EXPECT_TRUE(s.coloured) << "seed " << seed;
    EXPECT_GT(s.scatter, 2.0) << "seed " << seed;
    EXPECT_GT(s.log10_p, log10_chi_square_tail(s.statistic, s.dof)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace magimu
