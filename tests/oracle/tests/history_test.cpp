// SPDX-License-Identifier: BSD-3-Clause
// The effects with a history are what effects.h says.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/oracle/mag_model.h"
#include "tests/oracle/tests/comparison.h"

namespace magimu::oracle {
namespace {

constexpr double kFrom = 9.995, kTo = 20.005;  // between samples
bool on(double t) { return t > kFrom && t < kTo; }

const Vector3d kZero = Vector3d::Zero();

// What the magnetometer would read.
Vector3d h(const Comparison& c, double t) {
  return c.device.distortion * c.b(t) + c.device.mag_bias;
}

TEST(History, mag_gain_change_multiplies_the_whole_reading_of_an_axis) {
  const Comparison c(make_effect("mag_gain_change", {0.0, 0.05, 0.0, kFrom, kTo}));
  c.only_mag(
      [&](double t) -> Vector3d { return on(t) ? Vector3d(0.0, 0.05 * h(c, t).y(), 0.0) : kZero; });
}

TEST(History, soft_iron_change_adds_a_matrix_times_the_unit_field) {
  const Comparison c(make_effect("soft_iron_change", {1, 2, 3, 4, 5, 6, 7, 8, 9, kFrom, kTo}));
  Matrix3d A;
  A << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  c.only_mag([&](double t) -> Vector3d { return on(t) ? Vector3d(A * c.b(t)) : kZero; });
}

TEST(History, gyro_gain_change_multiplies_rate_and_bias) {
  const Comparison c(make_effect("gyro_gain_change", {0.01, -0.02, 0.03, 10.0, 20.0}));
  c.only_gyr(
      [&](double t) -> Vector3d {
        const bool now = t >= 10.0 && t < 20.0;
        const Vector3d reading = c.motion.omega(t) + c.device.gyr_bias;
        return now ? Vector3d(Vector3d(0.01, -0.02, 0.03).cwiseProduct(reading)) : kZero;
      },
      1e-7);
}

TEST(History, mag_board_turn_turns_field_and_hard_iron) {
  const Comparison c(make_effect("mag_board_turn", {0.0, 0.0, 0.1, kFrom, kTo}));
  Matrix3d turn;
  turn << std::cos(0.1), -std::sin(0.1), 0, std::sin(0.1), std::cos(0.1), 0, 0, 0, 1;
  c.only_mag(
      [&](double t) -> Vector3d { return on(t) ? Vector3d(turn * h(c, t) - h(c, t)) : kZero; });
}

TEST(History, second_device_gives_every_nth_sample_of_its_time) {
  const double never = std::numeric_limits<double>::infinity();
  const std::vector<double> same = {1, 0, 0, 0, 2, 0, 0, 0, 3, 4, 5, 6};
  const auto with_times = [&](double every, double from, double to) {
    std::vector<double> p = same;
    p.insert(p.end(), {every, from, to});
    return make_effect("second_device", p);
  };
  const Comparison mixed(with_times(3.0, 0.0, never)), switched(with_times(1.0, kFrom, kTo));
  const auto other = [&](const Comparison& c, double t) -> Vector3d {
    return Vector3d(1, 2, 3).cwiseProduct(c.b(t)) + Vector3d(4, 5, 6);
  };
  mixed.only_mag([&](double t) -> Vector3d {
    return std::lround(100.0 * t) % 3 == 0 ? other(mixed, t) : kZero;
  });
  switched.only_mag([&](double t) -> Vector3d { return on(t) ? other(switched, t) : kZero; });
}

TEST(History, passing_phone_is_a_dipole_on_a_straight_way) {
  const Comparison c(
      make_effect("passing_phone", {0.1, 0.2, -0.3, 0.3, 0.2, 0.1, 0.0, 0.1, -0.2, 15.0}));
  c.only_mag([&](double t) -> Vector3d {
    const Vector3d phone(0.3, 0.2 + 0.1 * (t - 15.0), 0.1 - 0.2 * (t - 15.0));
    const Vector3d from = c.motion.position(t) - phone, m(0.1, 0.2, -0.3);
    const double r = from.norm();
    const Vector3d field = 0.1 * (3.0 * from * from.dot(m) / std::pow(r, 5) - m / std::pow(r, 3));
    const double strength = std::cbrt(c.device.distortion.determinant());
    return c.device.distortion * c.bRn(t) * field / strength;
  });
}

TEST(History, motor_current_starts_with_three_times_its_mean) {
  EXPECT_DOUBLE_EQ(motor_current(0.0, 5.0), 3.0);
  EXPECT_NEAR(motor_current(5.05, 5.0), 1.3, 1e-6);
  const Comparison c(make_effect("motor_current", {1, -2, 3, 0.7, kFrom, kTo}));
  c.only_mag([&](double t) -> Vector3d {
    if (!on(t)) return kZero;
    const double s = t - kFrom;
    return Vector3d(1, -2, 3) *
           (1.0 + 2.0 * std::exp(-s / 0.3) + 0.3 * std::sin(2.0 * std::numbers::pi * 0.7 * s));
  });
}

TEST(History, mag_hysteresis_stays_within_its_width_and_moves_only_when_pushed) {
  const Comparison c(make_effect("mag_hysteresis", {0.5}));
  const auto &clean = c.before.recording.mag[0].v, &stuck = c.after.recording.mag[0].v;
  int pushed = 0;
  for (std::size_t k = 1; k < clean.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      const double behind = std::abs(stuck[k][i] - clean[k][i]);
      EXPECT_LE(behind, 0.5 + 1e-12);
      EXPECT_TRUE(std::abs(behind - 0.5) < 1e-12 || stuck[k][i] == stuck[k - 1][i]);
      pushed += std::abs(behind - 0.5) < 1e-12;
    }
  }
  EXPECT_GT(pushed, 1000);
  EXPECT_EQ(c.before.recording.gyr.v, c.after.recording.gyr.v);
}

TEST(History, last_turn_offset_keeps_its_sign_until_the_next_turn_the_other_way) {
  const Comparison c(make_effect("last_turn_offset", {1, 2, 3, 0, 0, 2}));
  double sign = 0.0;
  int changes = 0;
  for (std::size_t k = 0; k < c.before.recording.mag[0].size(); ++k) {
    const double t = c.before.recording.mag[0].t[k], rate = c.motion.omega(t).z();
    const Vector3d offset = c.after.recording.mag[0].v[k] - c.before.recording.mag[0].v[k];
    if (std::abs(rate) > 0.31) {
      EXPECT_LT((offset - Vector3d(1, 2, 3) * (rate > 0.0 ? 1.0 : -1.0)).norm(), 1e-10);
    }
    const double now = std::round(offset.x());
    EXPECT_LT((offset - now * Vector3d(1, 2, 3)).norm(), 1e-10);
    changes += now != sign;
    sign = now;
  }
  EXPECT_GE(changes, 2);  // the first turn, and one the other way
}

}  // namespace
}  // namespace magimu::oracle
