// SPDX-License-Identifier: BSD-3-Clause
// The motions' kinematics: every derivative against differences, the attitude against closed forms.
#include "tests/oracle/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/oracle/random.h"

namespace magimu::oracle {
namespace {

constexpr MotionKind kAll[] = {
    MotionKind::kRotation,  MotionKind::kHandHeld, MotionKind::kOneAxis, MotionKind::kTranslation,
    MotionKind::kShortTurn, MotionKind::kStill,    MotionKind::kLevel};

Motion motion_of(MotionKind kind, std::uint64_t seed = 3, double duration_s = 40.0) {
  MotionOptions options;
  options.kind = kind;
  options.duration_s = duration_s;
  return Motion(options, seed);
}

// The rotation vector of a^-1 b.
Vector3d turn_between(const Quaterniond& a, const Quaterniond& b) {
  const Eigen::AngleAxisd turn(a.conjugate() * b);
  return turn.angle() * turn.axis();
}

TEST(Motion, derivatives_agree_with_differences_at_any_time) {
  constexpr double h = 1e-4;
  for (const MotionKind kind : kAll) {
    const Motion motion = motion_of(kind);
    Random random(1, Stream::kMotion, 99);
    for (int i = 0; i < 300; ++i) {
      const double t = random.uniform(0.0, 40.0);
      const auto quotient = [&](auto&& f) -> Vector3d { return (f(t + h) - f(t - h)) / (2 * h); };
      const Vector3d v = quotient([&](double s) { return motion.position(s); });
      const Vector3d a = quotient([&](double s) { return motion.velocity(s); });
      const Vector3d omega_dot = quotient([&](double s) { return motion.omega(s); });
      const Vector3d omega = turn_between(motion.nRb(t - h), motion.nRb(t + h)) / (2 * h);
      EXPECT_LT((motion.velocity(t) - v).norm(), 1e-5);
      EXPECT_LT((motion.acceleration(t) - a).norm(), 1e-4);
      EXPECT_LT((motion.angular_acceleration(t) - omega_dot).norm(), 1e-4);
      EXPECT_LT((motion.omega(t) - omega).norm(), 1e-5) << to_string(kind) << " at " << t;
    }
  }
}

TEST(Motion, integrated_acceleration_is_the_velocity_and_integrated_velocity_the_position) {
  const Motion motion = motion_of(MotionKind::kHandHeld);
  Vector3d v = Vector3d::Zero(), p = Vector3d::Zero();
  constexpr double h = 1e-3;
  for (int i = 0; i < 30000; ++i) {  // Simpson
    const double t = i * h;
    p += h / 6.0 * (motion.velocity(t) + 4.0 * motion.velocity(t + h / 2) + motion.velocity(t + h));
    v += h / 6.0 *
         (motion.acceleration(t) + 4.0 * motion.acceleration(t + h / 2) +
          motion.acceleration(t + h));
  }
  EXPECT_LT((v - motion.velocity(30.0)).norm(), 1e-9);
  EXPECT_LT((p - motion.position(30.0)).norm(), 1e-9);
}

// Runge and Kutta's fourth order on the matrix at 4 kHz, an integrator of another kind.
TEST(Motion, attitude_solves_the_kinematic_equation) {
  for (const MotionKind kind :
       {MotionKind::kHandHeld, MotionKind::kShortTurn, MotionKind::kLevel}) {
    const Motion motion = motion_of(kind, 5);
    const auto slope = [&](const Matrix3d& R, double t) -> Matrix3d {
      const Vector3d w = motion.omega(t);
      Matrix3d W;
      W << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
      return R * W;
    };
    Matrix3d R = motion.nRb(0.0).toRotationMatrix();
    constexpr double h = 2.5e-4;
    for (int i = 0; i < 80000; ++i) {
      const double t = i * h;
      const Matrix3d k1 = slope(R, t), k2 = slope(R + 0.5 * h * k1, t + 0.5 * h);
      const Matrix3d k3 = slope(R + 0.5 * h * k2, t + 0.5 * h), k4 = slope(R + h * k3, t + h);
      R += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    EXPECT_LT((R - motion.nRb(20.0).toRotationMatrix()).norm(), 1e-10) << to_string(kind);
  }
}

TEST(Motion, right_jacobian_is_the_derivative_of_exp) {
  for (const double size : {0.0, 1e-6, 0.015, 0.025, 1.0, 3.0}) {
    const Vector3d v = size * Vector3d(0.36, -0.48, 0.8), step = 1e-6 * Vector3d(0.3, 0.5, -0.7);
    const Vector3d expected = turn_between(exp_so3(v - step), exp_so3(v + step));
    EXPECT_LT((2.0 * right_jacobian_so3(v) * step - expected).norm(), 1e-14) << size;
  }
}

TEST(Motion, rests_are_exact_at_start_end_and_in_the_middle) {
  for (const MotionKind kind : kAll) {
    MotionOptions options;
    options.kind = kind;
    options.duration_s = 40.0;
    options.carry_m = 0.3;
    const Motion motion(options, 3);
    for (const double t : {0.0, 1.0, 2.999, 19.01, 20.0, 20.99, 37.001, 39.0, 40.0, 41.0}) {
      EXPECT_TRUE(motion.omega(t).isZero(0.0)) << to_string(kind) << " at " << t;
      EXPECT_TRUE(motion.angular_acceleration(t).norm() < 1e-12);
      EXPECT_TRUE(motion.velocity(t).isZero(0.0));
      EXPECT_TRUE(motion.acceleration(t).isZero(0.0));
    }
    EXPECT_EQ(motion.nRb(0.0).coeffs(), motion.nRb(2.9).coeffs());
    EXPECT_EQ(motion.nRb(38.0).coeffs(), motion.nRb(50.0).coeffs());
  }
}

TEST(Motion, rests_stay_exact_wherever_the_sensor_is_carried) {
  MotionOptions options;
  options.kind = MotionKind::kHandHeld;
  options.duration_s = 22.0;  // stretches of movement about as long as the carrying
  options.carry_m = 0.3;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Motion motion(options, seed);
    for (const double t : {0.5, 2.99, 10.01, 11.0, 11.99, 19.01, 21.0}) {
      EXPECT_TRUE(motion.velocity(t).isZero(0.0)) << "seed " << seed << " at " << t;
    }
  }
}

TEST(Motion, has_no_rest_in_the_middle_if_none_is_asked_for) {
  MotionOptions options;
  options.duration_s = 40.0;
  options.pause_s = 0.0;
  EXPECT_GT(Motion(options, 3).omega(20.0).norm(), 0.1);
}

TEST(Motion, rotation_is_as_fast_as_asked_and_turns_about_all_axes_both_ways) {
  for (const double fastest : {0.1, 0.5, 2.5, 3.0}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      MotionOptions options;
      options.fastest_rad_s = fastest;
      options.duration_s = 120.0;
      const Motion motion(options, seed);
      double most = 0.0;
      Vector3d least_axis = Vector3d::Zero(), most_axis = Vector3d::Zero();
      for (double t = 0.0; t < 120.0; t += 0.05) {
        const Vector3d w = motion.omega(t) / fastest;
        most = std::max(most, w.norm());
        least_axis = least_axis.cwiseMin(w);
        most_axis = most_axis.cwiseMax(w);
      }
      EXPECT_GT(most, 0.6);
      EXPECT_LT(most, 1.15);
      EXPECT_LT(least_axis.maxCoeff(), -0.2) << fastest << ", seed " << seed;
      EXPECT_GT(most_axis.minCoeff(), 0.2) << fastest << ", seed " << seed;
    }
  }
}

TEST(Motion, one_axis_keeps_to_the_axis_and_turns_far) {
  MotionOptions options;
  options.kind = MotionKind::kOneAxis;
  options.axis = Vector3d(1.0, 2.0, 2.0);
  const Motion motion(options, 4);
  double farthest = 0.0;
  for (double t = 0.0; t < 120.0; t += 0.05) {
    EXPECT_LT(motion.omega(t).cross(options.axis).norm(), 1e-14);
    farthest = std::max(farthest, turn_between(motion.nRb(0), motion.nRb(t)).norm());
  }
  EXPECT_GT(farthest, 90.0 * kDegree);
}

TEST(Motion, translation_and_short_turn_stay_near_their_first_attitude) {
  for (const auto& [kind, least, most] : {std::tuple(MotionKind::kTranslation, 5.0, 10.0),
                                          std::tuple(MotionKind::kShortTurn, 30.0, 40.0)}) {
    const Motion motion = motion_of(kind, 6, 120.0);
    double farthest = 0.0;
    for (double t = 0.0; t < 120.0; t += 0.05) {
      farthest = std::max(farthest, turn_between(motion.nRb(0), motion.nRb(t)).norm());
    }
    EXPECT_GT(farthest, least * kDegree);
    EXPECT_LT(farthest, most * kDegree);
    EXPECT_EQ(motion.position(30.0).isZero(0.0), kind == MotionKind::kShortTurn);
  }
}

TEST(Motion, displacement_has_the_size_asked_for_within_its_band) {
  for (const double size : {0.05, 0.3}) {
    MotionOptions options;
    options.kind = MotionKind::kHandHeld;
    options.displacement_m = size;
    options.pause_s = 0.0;
    const Motion motion(options, 8);
    double p2 = 0.0, v2 = 0.0;
    int count = 0;
    for (double t = 3.0; t < 117.0; t += 0.01, ++count) {
      p2 += motion.position(t).squaredNorm();
      v2 += motion.velocity(t).squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(p2 / count), size, 0.01 * size);
    const double mean_hz = std::sqrt(v2 / p2) / (2.0 * std::numbers::pi);
    EXPECT_GT(mean_hz, 0.3);
    EXPECT_LT(mean_hz, 1.5);
  }
}

TEST(Motion, carrying_goes_that_far_and_returns) {
  MotionOptions options;
  options.kind = MotionKind::kHandHeld;
  options.displacement_m = 0.0;
  options.carry_m = 0.4;
  const Motion motion(options, 8);
  double farthest = 0.0;
  for (double t = 0.0; t < 120.0; t += 0.05) {
    farthest = std::max(farthest, motion.position(t).norm());
  }
  EXPECT_NEAR(farthest, 0.4, 1e-3);
  EXPECT_TRUE(motion.position(120.0).isZero(0.0));
}

TEST(Motion, a_seed_is_one_motion) {
  for (const MotionKind kind : kAll) {
    const Motion a = motion_of(kind, 11), b = motion_of(kind, 11), c = motion_of(kind, 12);
    EXPECT_EQ(a.nRb(15.3).coeffs(), b.nRb(15.3).coeffs());
    EXPECT_EQ(a.position(15.3), b.position(15.3));
    EXPECT_NE(a.nRb(15.3).coeffs(), c.nRb(15.3).coeffs());
  }
}

}  // namespace
}  // namespace magimu::oracle
