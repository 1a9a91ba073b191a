// SPDX-License-Identifier: BSD-3-Clause
// The terms of factors/effects/ against the tests' oracle, which has the same equations, from
// docs/effects.md, and shares no line with them: what each effect changes in the oracle's exact
// readings is the term of the oracle's own motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "factors/effects/catalogue.h"
#include "tests/oracle/imu_model.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

oracle::Options exact() {
  oracle::Options options;
  options.seed = 6;
  options.motion.kind = oracle::MotionKind::kHandHeld;
  options.motion.duration_s = 20.0;
  options.motion.pause_s = 0.0;
  options.motion.rest_s = 1.0;
  options.noise_factor = 0.0;
  return options;
}

class OracleMotion {
 public:
  OracleMotion() : motion_(options_.motion, options_.seed), plain(oracle::simulate(options_)) {
    const std::vector<double>& t = plain.truth.t;
    for (std::size_t k = 0; k < t.size(); ++k) {
      mean_temperature_ += oracle::warming_up(t[k]) / double(t.size());
      mean_position += plain.truth.p[k] / double(t.size());
    }
  }

  SampleState state(Sensor channel, double t) const {
    const oracle::Device& device = plain.truth.device;
    const oracle::Instant at = oracle::instant(motion_, options_.gravity, t);
    SampleState s;
    s.t = t;
    s.duration_s = options_.motion.duration_s;
    s.u = 2.0 * t / s.duration_s - 1.0;
    s.nRb = Rot3::from_matrix(at.bRn.transpose());
    s.omega = at.omega;
    s.omega_rate = motion_.angular_acceleration(t);
    s.f = at.f;
    s.b = at.bRn * device.unit_field();
    s.D = device.distortion;
    s.bias = channel == Sensor::kAcc   ? device.acc_bias
             : channel == Sensor::kGyr ? device.gyr_bias
                                       : device.mag_bias;
    s.strength_uT = device.strength_uT();
    s.temperature = oracle::warming_up(t) - mean_temperature_;
    s.current = oracle::switching_current(t);
    s.position = at.p;
    s.position_mean = mean_position;
    s.force_change = [this, t](double delay) -> Vector3 {
      return oracle::instant(motion_, options_.gravity, t - delay).f -
             oracle::instant(motion_, options_.gravity, t).f;
    };
    s.field_before = [this, t](double delay) -> Vector3 {
      return motion_.nRb(t - delay).conjugate() * plain.truth.device.unit_field();
    };
    return s;
  }
  oracle::Simulation with(const oracle::Effect& effect) const {
    oracle::Options options = options_;
    options.effects = {effect};
    return oracle::simulate(options);
  }

 private:
  oracle::Options options_ = exact();
  oracle::Motion motion_;
  double mean_temperature_ = 0.0;

 public:
  oracle::Simulation plain;
  Vector3 mean_position = Vector3::Zero();
};

const OracleMotion& shared_motion() {
  static const OracleMotion motion;
  return motion;
}

struct Case {
  std::shared_ptr<const Effect> effect;
  VectorXd theta;
};
// The effect of ours with the oracle's parameters.
Case same(const oracle::Effect& e) {
  const VectorXd& p = e.parameters;
  const std::string& name = e.name();
  if (is_change(name)) {
    const Eigen::Index n = p.size() - 2;
    return {make_change(name, forms_of_change(name).front(),
                        {.begin = {0, p[n]}, .end = {0, p[n + 1]}}),
            p.head(n)};
  }
  if (name == "mains_interference") return {make_mains_at(p[6]), p.head(6)};
  const auto effect = find_effect(name);
  if (const auto family = effect->with_terms(int(p.size()) / 3)) return {family, p};
  VectorXd theta = p;
  return {effect, theta};
}

class EffectAndOracle : public testing::TestWithParam<std::string> {};

TEST_P(EffectAndOracle, agree) {
  const OracleMotion& motion = shared_motion();
  oracle::EffectScale scale;
  scale.duration_s = 20.0;
  const oracle::Effect hidden = oracle::random_effect(GetParam(), 6, scale);
  const auto [effect, theta] = same(hidden);
  ASSERT_EQ(effect->size(), theta.size());
  const oracle::Simulation with = motion.with(hidden);
  const Sensor channel = effect->channel();
  const auto series = [&](const Recording& r) -> const VectorSeries& {
    return channel == Sensor::kAcc ? r.acc : channel == Sensor::kGyr ? r.gyr : r.mag[0];
  };
  const VectorSeries &before = series(motion.plain.recording), &after = series(with.recording);
  // The mean over an interval within which a change begins is known to a point of the quadrature.
  const ChangeEffect* const change_of = as_change(*effect);
  const auto changes_within = [&](double t) {
    const auto within = [&](const Moment& m) { return m.t >= t && m.t < t + 0.01; };
    return change_of != nullptr && channel == Sensor::kGyr &&
           (within(change_of->span().begin) || within(change_of->span().end));
  };
  double worst = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < before.size(); k += 3) {
    if (changes_within(before.t[k])) continue;
    Vector3 term = Vector3::Zero();
    const int points = channel == Sensor::kGyr ? 20 : 1;
    for (int i = 0; i < points; ++i) {
      const double share = channel == Sensor::kGyr ? (i + 0.5) / points : 0.0;
      term += effect->term(motion.state(channel, before.t[k] + 0.01 * share), theta) / points;
    }
    const Vector3 change = after.v[k] - before.v[k];
    largest = std::max(largest, change.norm());
    worst = std::max(worst, (change - term).norm());
  }
  // Of a lag, quadrature against the filter in steps of 1 ms.
  const double share = GetParam() == "mag_lag" ? 1e-3 : channel == Sensor::kGyr ? 1e-5 : 1e-9;
  EXPECT_GT(largest, 1e-5);
  EXPECT_LT(worst, share * largest);
}

INSTANTIATE_TEST_SUITE_P(
    Catalogue, EffectAndOracle,
    testing::Values("acc_scale_misalignment", "gyro_scale_misalignment", "gyro_g_sensitivity",
                    "gyro_nonlinearity", "gyro_temperature", "acc_temperature", "mag_temperature",
                    "lever_arm", "mag_time_offset", "mag_lag", "mag_eddy_current", "field_drift",
                    "hard_iron_drift", "hard_iron_change", "field_gradient", "stationary_source",
                    "mag_nonlinearity", "mag_current", "mains_interference", "acc_time_offset",
                    "gravity", "mag_own_clock", "mag_change", "gyro_change", "acc_change",
                    "mag_axis_time_offset", "acc_bias_drift", "acc_bias_change", "gyro_bias_change",
                    "mag_gain_drift", "gyro_gain_drift", "acc_nonlinearity", "field_change"),
    [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace magimu
