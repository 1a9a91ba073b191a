// SPDX-License-Identifier: BSD-3-Clause
// Recordings without effects: the sensor models, times, noise, seeds.
#include "tests/oracle/sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace magimu::oracle {
namespace {

Options ideal(MotionKind kind, double duration_s = 30.0) {
  Options options;
  options.motion.kind = kind;
  options.motion.duration_s = duration_s;
  options.noise_factor = 0.0;
  return options;
}

TEST(Oracle, a_level_sensor_at_rest_reads_gravity_upward_and_the_field_northward_and_down) {
  Options options = ideal(MotionKind::kStill, 5.0);
  options.device = Device();
  const Simulation s = simulate(options);
  const Matrix3d R = s.truth.nRb[0].matrix();
  EXPECT_LT((R * s.recording.acc.v[7] - Vector3d(0, 0, 9.80665)).norm(), 1e-12);
  const double dip = Device().dip_rad;
  const Vector3d field = 27.0 * Vector3d(0, std::cos(dip), -std::sin(dip));
  EXPECT_LT((R * s.recording.mag[0].v[7] - field).norm(), 1e-12);
  EXPECT_EQ(s.recording.gyr.v[7], Vector3d(0, 0, 0));
}

TEST(Oracle, readings_follow_the_models_in_motion) {
  const Simulation s = simulate(ideal(MotionKind::kHandHeld));
  const Device& d = s.truth.device;
  for (std::size_t k = 1; k + 1 < s.truth.t.size(); k += 7) {
    const Matrix3d bRn = s.truth.nRb[k].matrix().transpose();
    const Vector3d a = (s.truth.v[k + 1] - s.truth.v[k - 1]) / 0.02;  // to 1e-2
    const Vector3d mag = d.distortion * bRn * d.unit_field() + d.mag_bias;
    EXPECT_LT((s.recording.mag[0].v[k] - mag).norm(), 1e-11);
    EXPECT_LT((s.recording.acc.v[k] - bRn * (a + Vector3d(0, 0, 9.80665)) - d.acc_bias).norm(),
              0.05);
  }
}

TEST(Oracle, gyroscope_samples_lead_from_one_attitude_to_the_next_about_a_fixed_axis) {
  const Simulation s = simulate(ideal(MotionKind::kOneAxis));
  for (std::size_t k = 0; k + 1 < s.truth.t.size(); ++k) {
    const Vector3d turn = (s.recording.gyr.v[k] - s.truth.device.gyr_bias) * 0.01;
    const Rot3 next = s.truth.nRb[k] * Rot3::Exp(turn);
    EXPECT_LT((next.matrix() - s.truth.nRb[k + 1].matrix()).norm(), 1e-12);
  }
}

TEST(Oracle, gyroscope_samples_lead_from_one_attitude_to_the_next_up_to_coning_otherwise) {
  double worst = 0.0;
  for (const double rate : {100.0, 200.0}) {
    Options options = ideal(MotionKind::kRotation);
    options.rate_hz = rate;
    const Simulation s = simulate(options);
    double now = 0.0;
    for (std::size_t k = 0; k + 1 < s.truth.t.size(); ++k) {
      const Vector3d rate_k = s.recording.gyr.v[k] - s.truth.device.gyr_bias;
      const Vector3d true_turn = (s.truth.nRb[k].inverse() * s.truth.nRb[k + 1]).Log();
      now = std::max(now, (rate_k - true_turn * rate).norm());
    }
    EXPECT_LT(now, 2e-4);
    if (worst > 0.0) {
      EXPECT_NEAR(worst / now, 4.0, 0.2);  // of second order in the interval
    }
    worst = now;
  }
}

TEST(Oracle, a_slower_gyroscope_reads_the_mean_of_a_faster_one) {
  Options options = ideal(MotionKind::kRotation);
  const Simulation fast = simulate(options);
  options.rate_hz = 20.0;
  const Simulation slow = simulate(options);
  for (std::size_t k = 0; k < slow.truth.t.size(); ++k) {
    Vector3d mean = Vector3d::Zero();
    for (std::size_t i = 0; i < 5; ++i) mean += fast.recording.gyr.v[5 * k + i] / 5.0;
    EXPECT_LT((mean - slow.recording.gyr.v[k]).norm(), 1e-12);
  }
}

TEST(Oracle, a_magnetometer_has_times_of_its_own) {
  Options options = ideal(MotionKind::kRotation, 20.0);
  options.mag_rate_hz = 40.0;
  options.mag_first_s = 0.003;
  const Simulation s = simulate(options);
  ASSERT_EQ(s.recording.mag[0].size(), 800u);
  EXPECT_DOUBLE_EQ(s.recording.mag[0].t[4], 0.103);
  EXPECT_EQ(s.recording.acc.size(), 2000u);
  EXPECT_DOUBLE_EQ(s.recording.gyr.t[200], 2.0);
  // The same instants from a recording at a rate that has them all.
  options.rate_hz = 1000.0;
  options.mag_rate_hz = 0.0;
  options.mag_first_s = 0.0;
  const Simulation dense = simulate(options);
  EXPECT_LT((dense.recording.mag[0].v[10003] - s.recording.mag[0].v[400]).norm(), 1e-11);
}

TEST(Oracle, noise_is_white_with_the_density_asked_for) {
  Options options = ideal(MotionKind::kHandHeld, 120.0);
  options.mag_rate_hz = 50.0;
  const Simulation clean = simulate(options);
  options.noise_factor = 2.0;
  const Simulation noisy = simulate(options);
  const auto check = [](const VectorSeries& a, const VectorSeries& b, double sigma) {
    double sum = 0.0, squares = 0.0, lag1 = 0.0, fourth = 0.0;
    const double n = 3.0 * static_cast<double>(a.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      const Vector3d e = (a.v[k] - b.v[k]) / sigma;
      sum += e.sum();
      squares += e.squaredNorm();
      fourth += e.array().pow(4).sum();
      if (k > 0) lag1 += e.dot(a.v[k - 1] - b.v[k - 1]) / sigma;
    }
    const double five = 5.0 / std::sqrt(n);
    EXPECT_NEAR(sum / n, 0.0, five);
    EXPECT_NEAR(squares / n, 1.0, std::sqrt(2.0) * five);
    EXPECT_NEAR(lag1 / n, 0.0, five);
    EXPECT_NEAR(fourth / n, 3.0, std::sqrt(96.0) * five);
  };
  check(noisy.recording.acc, clean.recording.acc, 2.0 * 0.02 * 10.0);
  check(noisy.recording.gyr, clean.recording.gyr, 2.0 * 8.7e-4 * 10.0);
  check(noisy.recording.mag[0], clean.recording.mag[0], 2.0 * 0.003 * std::sqrt(50.0));
  EXPECT_DOUBLE_EQ(noisy.truth.noise.acc, 0.04);
}

TEST(Oracle, a_seed_is_one_recording) {
  Options options;
  options.motion.duration_s = 10.0;
  options.seed = 5;
  const Simulation a = simulate(options), b = simulate(options);
  EXPECT_EQ(a.recording.acc.v, b.recording.acc.v);
  EXPECT_EQ(a.recording.gyr.v, b.recording.gyr.v);
  EXPECT_EQ(a.recording.mag[0].v, b.recording.mag[0].v);
  options.seed = 6;
  options.device_seed = options.motion_seed = 5;
  const Simulation c = simulate(options);
  EXPECT_NE(a.recording.acc.v, c.recording.acc.v);
  EXPECT_EQ(a.truth.device.distortion, c.truth.device.distortion);
  EXPECT_EQ(a.truth.p, c.truth.p);
  EXPECT_EQ(a.truth.nRb[700].quaternion(), c.truth.nRb[700].quaternion());
}

TEST(Oracle, devices_lie_within_their_ranges) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Device paper = draw_device(DeviceKind::kTableI, seed);
    EXPECT_LE(paper.acc_bias.cwiseAbs().maxCoeff(), 0.5);
    EXPECT_LE(paper.gyr_bias.maxCoeff(), 0.67 * kDegree);
    EXPECT_GE(paper.gyr_bias.minCoeff(), 0.47 * kDegree);
    EXPECT_LE(paper.mag_bias.cwiseAbs().maxCoeff(), 2.0);
    EXPECT_NEAR(paper.dip_rad, 72.0 * kDegree, 5.0 * kDegree);
    EXPECT_NEAR(paper.strength_uT(), 27.0, 4.0);
    const Device board = draw_device(DeviceKind::kBoard, seed);
    EXPECT_NEAR(board.strength_uT(), 48.0, 6.0);
    EXPECT_LE(board.mag_bias.cwiseAbs().maxCoeff(), 30.0);
  }
}

TEST(Oracle, columns_are_recorded_if_asked_for) {
  Options options = ideal(MotionKind::kHandHeld, 20.0);
  const Recording without = simulate(options).recording;
  EXPECT_TRUE(without.aux.empty());
  EXPECT_FALSE(without.pos.has_value());
  options.record_temp = options.record_current = options.record_pos = true;
  const Simulation with = simulate(options);
  EXPECT_DOUBLE_EQ(with.recording.aux.at("temp").v[300], warming_up(3.0));
  EXPECT_DOUBLE_EQ(with.recording.aux.at("current").v[300], switching_current(3.0));
  EXPECT_EQ(with.recording.pos->v, with.truth.p);
  EXPECT_EQ(with.recording.truth->position, with.truth.p);
}

TEST(Oracle, options_that_make_no_sense_are_refused) {
  Options options;
  options.rate_hz = 0.0;
  EXPECT_THROW(simulate(options), std::invalid_argument);
  options.rate_hz = 100.0;
  options.mag_first_s = 500.0;
  EXPECT_THROW(simulate(options), std::invalid_argument);
}

}  // namespace
}  // namespace magimu::oracle
