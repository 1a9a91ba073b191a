// SPDX-License-Identifier: BSD-3-Clause
// The effects outside of the catalogue are what effects.h says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/oracle/sensors.h"

namespace magimu::oracle {
namespace {

Options undisturbed(double duration_s = 60.0) {
  Options options;
  options.seed = 9;
  options.motion.kind = MotionKind::kHandHeld;
  options.motion.duration_s = duration_s;
  options.noise_factor = 0.0;
  return options;
}

Simulation simulated_with(const Effect& effect, Options options = undisturbed()) {
  options.effects = {effect};
  return simulate(options);
}

TEST(Outside, acc_hysteresis_stays_within_its_width_and_moves_only_when_pushed) {
  const Simulation clean = simulate(undisturbed()),
                   stuck = simulated_with(make_effect("acc_hysteresis", {0.2}));
  const auto &f = clean.recording.acc.v, &s = stuck.recording.acc.v;
  for (std::size_t k = 1; k < f.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_LE(std::abs(s[k][i] - f[k][i]), 0.2 + 1e-12);
      const bool pushed = std::abs(std::abs(s[k][i] - f[k][i]) - 0.2) < 1e-12;
      EXPECT_TRUE(pushed || s[k][i] == s[k - 1][i]);
    }
  }
}

TEST(Outside, gyro_rectification_is_the_mean_of_squared_force) {
  const Simulation clean = simulate(undisturbed());
  const Simulation s = simulated_with(make_effect("gyro_rectification", {1e-4, 2e-4, -3e-4}));
  for (std::size_t k = 0; k + 1 < s.recording.acc.size(); ++k) {
    const Vector3d f0 = clean.recording.acc.v[k] - clean.truth.device.acc_bias;
    const Vector3d f1 = clean.recording.acc.v[k + 1] - clean.truth.device.acc_bias;
    const Vector3d square = 0.5 * (f0.array().square() + f1.array().square());  // to 1 %
    const Vector3d difference = s.recording.gyr.v[k] - clean.recording.gyr.v[k];
    EXPECT_LT((difference - Vector3d(1e-4, 2e-4, -3e-4).cwiseProduct(square)).norm(), 4e-4);
  }
}

TEST(Outside, mag_memory_relaxes_towards_the_field) {
  const Simulation clean = simulate(undisturbed()),
                   s = simulated_with(make_effect("mag_memory", {0.05, 4.0}));
  const auto &m = clean.recording.mag[0].v, &r = s.recording.mag[0].v;
  for (std::size_t k = 1; k + 1 < m.size(); ++k) {
    const Vector3d slope = ((r[k + 1] - m[k + 1]) - (r[k - 1] - m[k - 1])) / 0.02;
    const Vector3d B = m[k] - clean.truth.device.mag_bias;
    EXPECT_LT((4.0 * slope + (r[k] - m[k]) - 0.05 * B).norm(), 2e-2);
  }
}

TEST(Outside, terms_of_the_magnetometer_follow_their_equations) {
  const Simulation clean = simulate(undisturbed());
  const Simulation moving =
      simulated_with(make_effect("moving_soft_iron", {1, .2, .3, .4, -1, .6, .7, .8, 2}));
  const Simulation cross = simulated_with(make_effect("mag_cross_axis", {0.1, 0.2, -0.3}));
  const Simulation cable = simulated_with(make_effect("cable_field", {1, 2, 3}));
  const Device& d = clean.truth.device;
  Matrix3d A;
  A << 1, .2, .3, .4, -1, .6, .7, .8, 2;
  for (std::size_t k = 0; k < clean.truth.t.size(); k += 5) {
    const Rot3& R = clean.truth.nRb[k];
    const Vector3d m = clean.recording.mag[0].v[k];
    const Vector3d b = R.unrotate(d.unit_field()), B = d.distortion * b;
    const Vector3d f = clean.recording.acc.v[k] - d.acc_bias;
    EXPECT_LT((moving.recording.mag[0].v[k] - m - f.z() / f.norm() * (A * b)).norm(), 1e-10);
    const Vector3d product(.1 * B.y() * B.z(), .2 * B.z() * B.x(), -.3 * B.x() * B.y());
    EXPECT_LT((cross.recording.mag[0].v[k] - m - product / 50.0).norm(), 1e-10);
    const double theta = (clean.truth.nRb[0].inverse() * R).Log().norm();
    EXPECT_LT(
        (cable.recording.mag[0].v[k] - m - (1.0 - std::cos(theta)) * Vector3d(1, 2, 3)).norm(),
        1e-10);
  }
}

TEST(Outside, acc_tapping_is_blows_at_the_rate_and_size_asked_for) {
  const Simulation clean = simulate(undisturbed(600.0));
  const Simulation s = simulated_with(make_effect("acc_tapping", {0.5, 10.0}), undisturbed(600.0));
  int blows = 0, quiet = 100;
  double most = 0.0;
  for (std::size_t k = 0; k < s.recording.acc.size(); ++k) {
    const double size = (s.recording.acc.v[k] - clean.recording.acc.v[k]).norm();
    most = std::max(most, size);
    blows += size > 0.0 && quiet > 10;
    quiet = size > 0.0 ? 0 : quiet + 1;
  }
  EXPECT_NEAR(blows, 290, 60);
  EXPECT_GT(most, 4.0);
  EXPECT_LT(most, 15.0);
}

TEST(Outside, mag_time_jitter_is_the_field_of_another_time) {
  const Simulation clean = simulate(undisturbed()),
                   s = simulated_with(make_effect("mag_time_jitter", {0.002}));
  double squares = 0.0, weight = 0.0;  // of the error along the field's motion, in seconds
  for (std::size_t k = 1; k + 1 < s.recording.mag[0].size(); ++k) {
    const Vector3d slope =
        (clean.recording.mag[0].v[k + 1] - clean.recording.mag[0].v[k - 1]) / 0.02;
    const Vector3d error = s.recording.mag[0].v[k] - clean.recording.mag[0].v[k];
    squares += error.squaredNorm();
    weight += slope.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares / weight), 0.002, 2e-4);
}

}  // namespace
}  // namespace magimu::oracle
