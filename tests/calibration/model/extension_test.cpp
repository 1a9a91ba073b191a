// SPDX-License-Identifier: BSD-3-Clause
// A model extended by effects, on recordings of the oracle: at the truth it takes away what the
// effect has added, and from elsewhere it finds the truth.
#include "calibration/model/extension.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/fit/stage.h"
#include "calibration/model/sensed_motion.h"
#include "calibration/start/initialize.h"
#include "factors/effects/catalogue.h"
#include "solvers/marginals.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

oracle::Options options_for(oracle::MotionKind motion, double duration_s, double noise_factor) {
  oracle::Options options;
  options.seed = 9;
  options.motion.kind = motion;
  options.motion.duration_s = duration_s;
  options.noise = oracle::kRealisticDensities;
  options.noise_factor = noise_factor;
  options.record_temp = options.record_current = options.record_pos = true;
  return options;
}

// The model's variables at the truth.
Values true_values(const oracle::Truth& truth, const NodePlan& plan, double rate_hz) {
  Values values;
  for (std::size_t i = 0; i < plan.t.size(); ++i) {
    values.insert(R(int(i)), truth.nRb[std::size_t(std::lround(plan.t[i] * rate_hz))]);
  }
  values.insert(key::acc_bias, truth.device.acc_bias);
  values.insert(key::gyr_bias, truth.device.gyr_bias);
  values.insert(key::distortion, truth.device.distortion);
  values.insert(key::mag_bias, truth.device.mag_bias);
  values.insert(dip_of(0), truth.device.dip_rad);
  return values;
}

const VectorSeries& series(const Recording& r, Sensor channel) {
  return channel == Sensor::kAcc ? r.acc : channel == Sensor::kGyr ? r.gyr : r.mag.front();
}

struct Case {
  const char* name;
  bool hand_held;
  double share;  // of what the effect adds that may remain
};
std::string name_of(const testing::TestParamInfo<Case>& instance) {
  return std::string(instance.param.name) + (instance.param.hand_held ? "_moved" : "");
}

class ExtensionAtTheTruth : public testing::TestWithParam<Case> {};

TEST_P(ExtensionAtTheTruth, takes_away_what_the_effect_adds) {
  const Case c = GetParam();
  oracle::Options options = options_for(
      c.hand_held ? oracle::MotionKind::kHandHeld : oracle::MotionKind::kRotation, 30.0, 0.0);
  options.rate_hz = 200.0;
  const oracle::Simulation plain = oracle::simulate(options);
  oracle::EffectScale scale;
  scale.duration_s = 30.0;
  const oracle::Effect hidden = oracle::random_effect(c.name, 9, scale);
  options.effects = {hidden};
  const oracle::Simulation with = oracle::simulate(options);

  VectorXd theta = hidden.parameters;
  ModelSpec spec;
  spec.motion = c.hand_held ? MotionModel::kHandHeld : MotionModel::kRotation;
  spec.effects = {find_effect(c.name)};
  if (const auto family = spec.effects[0]->with_terms(int(theta.size()) / 3)) {
    spec.effects = {family};
  }
  if (is_change(c.name)) {
    const Eigen::Index n = theta.size() - 2;
    spec.effects = {make_change(c.name, forms_of_change(c.name).front(),
                                {.begin = {0, theta[n]}, .end = {0, theta[n + 1]}})};
    theta = theta.head(n).eval();
  }
  const std::vector<NodePlan> plans = plan_nodes({&with.recording}, 20);
  Values values = true_values(with.truth, plans[0], options.rate_hz);
  const auto keys = effect_keys(spec.effects);
  ASSERT_EQ(Eigen::Index(keys[0].size()), theta.size());
  for (std::size_t i = 0; i < keys[0].size(); ++i) {
    values.insert(keys[0][i], theta[Eigen::Index(i)]);
  }
  const ExtendedRecording extended = extend(with.recording, plans[0], spec, values);

  const Sensor channel = spec.effects[0]->channel();
  const auto& before = series(plain.recording, channel).v;
  const auto& raw = series(with.recording, channel).v;
  const auto& corrected = series(extended.corrected, channel).v;
  double added = 0.0, left = 0.0;
  for (std::size_t k = 40; k + 40 < raw.size(); ++k) {
    added += (raw[k] - before[k]).squaredNorm();
    left += (corrected[k] - before[k]).squaredNorm();
  }
  EXPECT_GT(added, 0.0);
  EXPECT_LT(std::sqrt(left / added), c.share);
  // Every column is the derivative of the term that was taken away, at the same state.
  EXPECT_EQ(extended.keys[std::size_t(channel)], keys[0]);
  EXPECT_EQ(extended.theta[std::size_t(channel)], theta);
  const SensedMotion motion(extended.corrected, plans[0], spec, values);
  for (const std::size_t k : {100u, 2500u, 4000u}) {
    const SampleState state = motion.state(channel, k);
    Eigen::Matrix<double, 3, Eigen::Dynamic> J(3, theta.size());
    spec.effects[0]->jacobian(state, theta, J);
    // The slope of a moved accelerometer's samples is that of the round before.
    const double round = c.hand_held && std::string(c.name) == "acc_time_offset" ? 2e-3 : 0.0;
    // So is the rate that attitudes have beside the gyroscope's: of second order in the effect.
    const double rate = channel == Sensor::kGyr ? 1e-4 : round;
    const double norm = J.norm();
    EXPECT_LT((extended.columns[std::size_t(channel)].of(k) - J).norm(),
              (1e-4 + round) * norm + 1e-9);
    EXPECT_LT((raw[k] - corrected[k] - spec.effects[0]->term(state, theta)).norm(),
              rate * norm * theta.norm() + 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Oracle, ExtensionAtTheTruth,
    testing::Values(
        Case{"acc_scale_misalignment", false, 1e-3}, Case{"acc_scale_misalignment", true, 0.02},
        Case{"gyro_scale_misalignment", false, 1e-3}, Case{"gyro_scale_misalignment", true, 1e-3},
        Case{"gyro_g_sensitivity", false, 2e-3}, Case{"gyro_g_sensitivity", true, 0.01},
        Case{"gyro_nonlinearity", false, 0.02}, Case{"gyro_temperature", false, 1e-3},
        Case{"acc_temperature", false, 1e-3}, Case{"mag_temperature", false, 1e-3},
        Case{"lever_arm", false, 0.01}, Case{"mag_time_offset", false, 2e-3},
        Case{"mag_lag", false, 5e-3}, Case{"mag_eddy_current", false, 5e-3},
        Case{"field_drift", false, 2e-3}, Case{"hard_iron_drift", false, 2e-3},
        Case{"hard_iron_change", false, 1e-9}, Case{"field_gradient", true, 2e-3},
        Case{"stationary_source", true, 2e-3}, Case{"mag_nonlinearity", false, 2e-3},
        Case{"mag_current", false, 1e-3}, Case{"gravity", false, 1e-7}, Case{"gravity", true, 1e-7},
        Case{"acc_time_offset", false, 2e-3}, Case{"acc_time_offset", true, 0.05},
        Case{"mag_own_clock", false, 2e-3}, Case{"mag_change", false, 1e-3},
        Case{"gyro_change", false, 0.02}, Case{"gyro_change", true, 0.02},
        Case{"acc_change", false, 1e-3}, Case{"acc_change", true, 0.02}),
    name_of);

// The attitudes of two nodes differ from what the gyroscope says by its noise. A delay that reaches
// back beyond the middle between them is the gyroscope's alone: else it would seem to be noise.
TEST(SensedMotion, a_delay_does_not_jump_between_nodes) {
  oracle::Options options = options_for(oracle::MotionKind::kRotation, 20.0, 0.0);
  options.rate_hz = 250.0;
  const oracle::Simulation s = oracle::simulate(options);
  const std::vector<NodePlan> plans = plan_nodes({&s.recording}, 11);
  Values values = true_values(s.truth, plans[0], options.rate_hz);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 3e-3);  // rad
  for (std::size_t i = 0; i < plans[0].t.size(); ++i) {
    const Vector3 error(noise(random), noise(random), noise(random));
    values.update(R(int(i)), Rot3::Exp(error) * values.at<Rot3>(R(int(i))));
  }
  const SensedMotion motion(s.recording, plans[0], {}, values);
  constexpr double kDelay = 2.2e-3;
  for (std::size_t k = 20; k + 20 < motion.samples(Sensor::kMag); ++k) {
    const SampleState state = motion.state(Sensor::kMag, k);
    const Vector3 step = state.field_before(kDelay) - state.b;
    // At a node the rate is that of the way on, and the delay reaches back.
    const Vector3 omega = motion.state(Sensor::kMag, k - 1).omega;
    EXPECT_LT((step - kDelay * omega.cross(state.b)).norm(), 2e-4) << "sample " << k;
  }
}

// Its noise would stand on both sides of an equation.
TEST(SensedMotion, turns_as_the_fit_estimates_and_not_as_the_gyroscope_reads) {
  const oracle::Options options = options_for(oracle::MotionKind::kRotation, 20.0, 3.0);
  const oracle::Simulation s = oracle::simulate(options);
  const std::vector<NodePlan> plans = plan_nodes({&s.recording}, 10);
  const Values values = true_values(s.truth, plans[0], options.rate_hz);
  const SensedMotion motion(s.recording, plans[0], {}, values);
  const VectorSeries& gyr = s.recording.gyr;
  const Vector3 bias = s.truth.device.gyr_bias;
  double as_estimated = 0.0, as_read = 0.0;
  std::size_t k = 0;
  for (std::size_t i = 0; i + 1 < plans[0].t.size(); ++i) {
    while (gyr.t[k] < plans[0].t[i] - 1e-9) ++k;
    Rot3 estimated, read;
    for (; gyr.t[k] < plans[0].t[i + 1] - 1e-9; ++k) {
      const double h = gyr.t[k + 1] - gyr.t[k];
      estimated = estimated * Rot3::Exp(h * motion.state(Sensor::kGyr, k).omega);
      read = read * Rot3::Exp(h * (gyr.v[k] - bias));
    }
    const Rot3 turned = values.at<Rot3>(R(int(i))).inverse() * values.at<Rot3>(R(int(i + 1)));
    as_estimated += (turned.inverse() * estimated).Log().squaredNorm();
    as_read += (turned.inverse() * read).Log().squaredNorm();
  }
  EXPECT_GT(as_read, 0.0);
  EXPECT_LT(as_estimated, 1e-3 * as_read);
}

// A stage at calibration's own level, started without the effect.
struct Fit {
  Fit(const oracle::Simulation& s, const std::shared_ptr<const Effect>& effect)
      : recordings{&s.recording} {
    ModelSpec spec;
    spec.noise = {s.truth.noise.acc, s.truth.noise.gyr, s.truth.noise.mag};
    Stage plain(recordings, spec, 2, {});
    const InitialGuess guess = initialize(recordings, {});
    plain.fit(initial_values(recordings, plain.plans(), guess, MotionModel::kRotation), false);
    spec = plain.spec();
    spec.effects = {effect};
    stage = std::make_unique<Stage>(recordings, spec, 2, OptimizerOptions{});
    stage->fit(carry_over(recordings, plain, *stage), false);
  }
  std::vector<const Recording*> recordings;
  std::unique_ptr<Stage> stage;
};

void expect_found(const std::string& name, double strength) {
  oracle::Options options = options_for(oracle::MotionKind::kRotation, 60.0, 1.0);
  oracle::EffectScale scale;
  scale.strength = strength;
  const oracle::Effect hidden = oracle::random_effect(name, 12, scale);
  options.effects = {hidden};
  const oracle::Simulation s = oracle::simulate(options);
  const auto effect = find_effect(name);
  const Fit fit(s, effect);
  const Result& result = fit.stage->result();
  ASSERT_TRUE(result.converged()) << result.message;
  const Marginals marginals(fit.stage->graph(), result.values);
  const std::vector<Key> keys = effect_keys({effect})[0];
  double size = 0.0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const double sigma = std::sqrt(marginals.covariance(keys[i])(0, 0));
    const double truth = hidden.parameters[Eigen::Index(i)];
    EXPECT_LT(std::abs(result.values.at<double>(keys[i]) - truth), 4.0 * sigma)
        << name << " " << i << ": true " << truth << ", sigma " << sigma;
    size = std::max(size, std::abs(truth) / sigma);
  }
  EXPECT_GT(size, 5.0) << "too small to say anything";
}

class ExtendedStage : public testing::TestWithParam<std::string> {};

TEST_P(ExtendedStage, finds_the_true_parameters) { expect_found(GetParam(), 1.0); }

INSTANTIATE_TEST_SUITE_P(Oracle, ExtendedStage,
                         testing::Values("gyro_scale_misalignment", "acc_scale_misalignment",
                                         "lever_arm", "mag_eddy_current", "mag_lag"),
                         [](const auto& instance) { return instance.param; });

// Where the third power of a scale error is no longer small beside its sigma.
TEST(LargeEffects, finds_large_scale_errors_too) { expect_found("gyro_scale_misalignment", 6.0); }

}  // namespace
}  // namespace magimu
