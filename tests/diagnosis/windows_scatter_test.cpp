// SPDX-License-Identifier: BSD-3-Clause
// The scatter of windows' scores at the optimum is 1 under white noise, however much of it the fit
// has followed: with nine parameters in twelve windows, and with more parameters than windows.
// And: by how much samples scatter more than was given.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/model/windows.h"
#include "calibration/pipeline.h"
#include "calibration/scan/scan.h"
#include "diagnosis/search/doubts.h"
#include "factors/effects/catalogue.h"
#include "statistics/tails.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

struct Fitted {
  explicit Fitted(const oracle::Options& o)
      : recording(oracle::simulate(o).recording), pipeline(recordings, options_of(o)) {}

  static CalibrationOptions options_of(const oracle::Options& o) {
    CalibrationOptions out;
    out.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
    return out;
  }

  Recording recording;
  std::vector<const Recording*> recordings = {&recording};
  Pipeline pipeline;
  Stage stage = pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kRotation));
};

Score tested(std::uint64_t seed, bool coloured, const std::shared_ptr<const Effect>& effect) {
  oracle::Options o;
  o.seed = seed;
  o.rate_hz = 50.0;
  o.noise = oracle::kRealisticDensities;
  o.motion.duration_s = 60.0;
  if (coloured) {  // 0.2 s in all channels
    using enum oracle::Channel;
    for (const oracle::Channel channel : {kAcc, kGyr, kMag}) {
      o.effects.push_back(oracle::make_effect("correlated_noise", {std::exp(-0.1)}, channel));
    }
  }
  const Fitted f(o);
  ModelSpec spec = f.stage.spec();
  spec.effects.push_back(effect);
  return wald_test(f.pipeline.refit_with_same_noise(f.stage, spec), 0);
}

TEST(WindowsScatter, is_one_under_white_noise) {
  for (const auto& effect :
       {find_effect("gyro_scale_misalignment"), make_gyro_bias_walk(16, 1e-4)}) {
    double sum = 0.0;
    int coloured = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Score s = tested(seed, false, effect);
      sum += s.scatter / 10.0;
      coloured += s.coloured ? 1 : 0;
    }
    EXPECT_NEAR(sum, 1.0, 0.12) << effect->name();
    EXPECT_LE(coloured, 2) << effect->name();
  }
}

// Five seconds hardly tell where a hand was and how fast it moved: what rounding makes of that must
// not take residuals with it, which are most of a score's scatter.
TEST(WindowsScatter, of_a_moved_sensor_does_not_hang_on_the_form_of_elimination) {
  oracle::Options o;
  o.seed = 5;
  o.rate_hz = 100.0;
  o.noise = oracle::kRealisticDensities;
  o.motion.kind = oracle::MotionKind::kHandHeld;
  o.motion.duration_s = 60.0;
  const Recording recording = oracle::simulate(o).recording;
  const std::vector<const Recording*> recordings = {&recording};
  const Pipeline pipeline(recordings, Fitted::options_of(o));
  const Stage stage = pipeline.coarse_fit(MotionModel::kHandHeld);
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const auto condensed = [&](EliminationForm form) {
    return condense(system, values, node_of, windows_of(stage.plans(), 5.0), form);
  };
  const CondensedChain one = condensed(EliminationForm::kInformation);
  const CondensedChain other = condensed(EliminationForm::kSquareRoot);
  // Of the accelerometer's bias and the lever arm the information form does lose digits.
  ASSERT_EQ(one.position(values, key::acc_bias), 0);
  const Eigen::Index globals = other.windows.front().score.size(), rest = globals - 6;
  ASSERT_EQ(one.position(values, key::lever_arm_of(0)), globals - 3);
  VectorXd information = VectorXd::Zero(rest);
  for (const CondensedWindow& w : other.windows) {
    information += w.information.diagonal().segment(3, rest);
  }
  for (std::size_t w = 0; w < one.windows.size(); ++w) {
    const VectorXd apart = (one.windows[w].score - other.windows[w].score).segment(3, rest);
    EXPECT_LT(apart.cwiseQuotient(information.cwiseSqrt()).cwiseAbs().maxCoeff(), 1e-3) << w;
  }
}

// A bias that drifts makes the scores of another cause scatter.
TEST(WindowsScatter, is_one_with_both_causes_in_the_model) {
  oracle::Options o;
  o.seed = 3;
  o.rate_hz = 50.0;
  o.noise = oracle::kRealisticDensities;
  o.motion.duration_s = 120.0;
  o.effects.push_back(
      oracle::make_effect("mag_eddy_current", {0.02, 0, 0, 0, 0.02, 0, 0, 0, 0.02}));
  o.effects.push_back(
      oracle::make_effect("hard_iron_drift", {0.17, -0.14, 0.1, 0.07, 0.17, -0.14}));
  const Fitted f(o);
  const Scan scan(f.recordings, f.stage,
                  {find_effect("mag_eddy_current"), find_effect("hard_iron_drift")->with_terms(2)});
  EXPECT_GT(scan.with_own_scatter(0).scatter, 2.0);
  EXPECT_NEAR(scan.scatter_with(0, 1), 1.0, 0.3);
}

TEST(ExcessOfSamples, is_what_outliers_add_to_the_variance_of_their_sensor) {
  oracle::Options o;
  o.rate_hz = 50.0;
  o.noise = oracle::kRealisticDensities;
  o.motion.duration_s = 240.0;
  o.effects.push_back(oracle::make_effect("outliers", {0.02, 8.0}, oracle::Channel::kMag));
  const Fitted f(o);
  const std::array<double, 3> excess =
      excess_of_samples({&f.recording}, f.stage, {o.noise.acc, o.noise.gyr, o.noise.mag});
  EXPECT_EQ(excess[0], 1.0);
  EXPECT_EQ(excess[1], 1.0);
  // 240 of 12,000 samples, by chance 15 more or less: 0.1.
  EXPECT_NEAR(excess[2], 1.0 + 0.02 * (64.0 - 1.0), 0.4);
}

TEST(WindowsScatter, is_large_under_coloured_noise) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Score s = tested(seed, true, find_effect("gyro_scale_misalignment"));
    EXPECT_TRUE(s.coloured) << "seed " << seed;
    EXPECT_GT(s.scatter, 2.0) << "seed " << seed;
    EXPECT_GT(s.log10_p, log10_chi_square_tail(s.statistic, s.dof)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace magimu
