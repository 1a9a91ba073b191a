// SPDX-License-Identifier: BSD-3-Clause
// The simulated motions: that they turn as their heads promise, and that discrete mean rates hold
// the whole of a motion in continuous time.
#include "sim/motions/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "sim/motions/hand_motion.h"
#include "sim/motions/turn_sequence.h"

namespace magimu {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr std::uint64_t kSeeds = 50;

AngularMotion sampled(const HandMotion& hand, double rate_hz, double duration_s) {
  return sample_motion(
      hand.initial_nRb(), [&](double t) { return hand.omega(t); }, rate_hz, duration_s);
}

Matrix3 cross_matrix(const Vector3& w) {
  Matrix3 m;
  m << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0;
  return m;
}

TEST(PaperMotion, takes_about_322_seconds) {
  EXPECT_NEAR(paper_motion_duration_s(), 60 * kTwoPi / 2 + 30 * kTwoPi / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(paper_motion_duration_s(), 322.0, 0.5);
}

TEST(PaperMotion, turns_once_about_each_axis_with_the_jitter_of_a_step) {
  const double rate_hz = 80.0;
  const AngularMotion motion = paper_motion(1, rate_hz, paper_motion_duration_s(), 0.0);
  EXPECT_EQ(motion.initial_nRb.quaternion(), Vector4(1, 0, 0, 0));
  const std::vector<Vector3> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  double begin = 0.0;
  for (const Vector3& axis : axes) {
    const double end = begin + kTwoPi / (0.1 * axis.norm());
    Vector3 sum = Vector3::Zero(), squares = Vector3::Zero();
    double count = 0.0;
    for (std::size_t k = 0; k < motion.mean_rate.size(); ++k) {
      const double t = static_cast<double>(k) / rate_hz;
      if (t < begin + 0.02 || t > end - 0.02) continue;  // not a step on the boundary
      const Vector3 jitter = motion.mean_rate[k] - 0.1 * axis;
      sum += jitter;
      squares += jitter.cwiseAbs2();
      count += 1.0;
    }
    EXPECT_NEAR(count, (end - begin) * rate_hz, 6.0);
    EXPECT_LT(sum.cwiseAbs().maxCoeff() / count, 4.5 * 0.05 / std::sqrt(count));
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(std::sqrt(squares[i] / count), 0.05, 0.05 * 4.5 / std::sqrt(2 * count));
    }
    begin = end;
  }
}

TEST(PaperMotion, rests_first_if_asked_and_then_moves_as_without) {
  const AngularMotion plain = paper_motion(2, 80.0, 10.0, 0.0);
  const AngularMotion rested = paper_motion(2, 80.0, 15.0, 5.0);
  ASSERT_EQ(rested.mean_rate.size(), 1200u);
  for (std::size_t k = 0; k < 400; ++k) EXPECT_TRUE(rested.mean_rate[k].isZero(0.0));
  for (std::size_t k = 0; k < 800; ++k) EXPECT_EQ(rested.mean_rate[400 + k], plain.mean_rate[k]);
}

TEST(PaperMotion, starts_over_when_it_lasts_longer_than_six_turns) {
  const double own = paper_motion_duration_s();
  const AngularMotion motion = paper_motion(1, 10.0, own + 60.0, 0.0);
  Vector3 mean = Vector3::Zero();
  for (std::size_t k = motion.mean_rate.size() - 500; k < motion.mean_rate.size(); ++k) {
    mean += motion.mean_rate[k] / 500.0;
  }
  EXPECT_LT((mean - Vector3(0.1, 0, 0)).norm(), 0.02);
}

// The oracle: R' = R [omega] by Runge and Kutta's method on the matrix, in steps of 0.25 ms.
TEST(SampleMotion, follows_the_kinematics_of_the_continuous_rate) {
  const double rate_hz = 80.0, duration = 20.0, h = 0.25e-3;
  const HandMotion hand(5, 120.0, 3.0);
  const std::vector<Rot3> nRb = integrate(sampled(hand, rate_hz, duration), rate_hz);
  Matrix3 R = hand.initial_nRb().matrix();
  for (std::size_t k = 0; k < nRb.size(); ++k) {
    ASSERT_LT((nRb[k].matrix() - R).norm(), 1e-9) << "at sample " << k;
    for (int i = 0; i < 50; ++i) {
      const double t = static_cast<double>(k) / rate_hz + i * h;
      const Matrix3 W0 = cross_matrix(hand.omega(t)), W1 = cross_matrix(hand.omega(t + h / 2)),
                    W2 = cross_matrix(hand.omega(t + h));
      const Matrix3 k1 = R * W0, k2 = (R + h / 2 * k1) * W1, k3 = (R + h / 2 * k2) * W1,
                    k4 = (R + h * k3) * W2;
      R += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
  }
}

TEST(SampleMotion, is_the_same_motion_at_any_rate) {
  const HandMotion hand(6, 120.0, 3.0);
  const std::vector<Rot3> slow = integrate(sampled(hand, 80.0, 120.0), 80.0);
  const std::vector<Rot3> fast = integrate(sampled(hand, 160.0, 120.0), 160.0);
  ASSERT_EQ(fast.size(), 2 * slow.size());
  for (std::size_t k = 0; k < slow.size(); ++k) {
    ASSERT_LT((slow[k].quaternion() - fast[2 * k].quaternion()).norm(), 1e-9) << "sample " << k;
  }
}

TEST(HandMotion, rests_exactly_still_at_the_start_the_end_and_in_between) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const HandMotion hand(seed, 120.0, 3.0);
    const auto& stretches = hand.stretches();
    EXPECT_GE(stretches.size(), 3u);  // 2 or 3 rests in the middle
    EXPECT_LE(stretches.size(), 4u);
    EXPECT_EQ(stretches.front().start, 3.0);
    EXPECT_NEAR(stretches.back().end, 117.0, 1e-9);
    for (std::size_t i = 1; i < stretches.size(); ++i) {
      const double rest = stretches[i].start - stretches[i - 1].end;
      EXPECT_GE(rest, 2.0 - 1e-9);
      EXPECT_LE(rest, 3.0 + 1e-9);
    }
    const AngularMotion motion = sampled(hand, 80.0, 120.0);
    const std::vector<Rot3> nRb = integrate(motion, 80.0);
    for (std::size_t k = 0; k + 1 < nRb.size(); ++k) {
      const double t0 = static_cast<double>(k) / 80.0, t1 = t0 + 1.0 / 80.0;
      const bool moving = std::any_of(stretches.begin(), stretches.end(), [&](const auto& s) {
        return t1 > s.start - 1e-9 && t0 < s.end + 1e-9;
      });
      if (moving) continue;
      EXPECT_TRUE(motion.mean_rate[k].isZero(0.0)) << t0;
      EXPECT_EQ(nRb[k].quaternion(), nRb[k + 1].quaternion()) << t0;
    }
  }
}

TEST(HandMotion, starts_roughly_level_with_any_heading) {
  double least = 1e9, most = -1e9;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Matrix3 R = HandMotion(seed, 120.0, 3.0).initial_nRb().matrix();
    EXPECT_GT(R(2, 2), std::cos(10.01 / 360.0 * kTwoPi));
    const double heading = std::atan2(R(1, 0), R(0, 0));
    least = std::min(least, heading);
    most = std::max(most, heading);
  }
  EXPECT_GT(most - least, 5.0);
}

TEST(HandMotion, turns_far_both_ways_about_every_axis_within_20_seconds) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const HandMotion hand(seed, 120.0, 3.0);
    Vector3 forward = Vector3::Zero(), backward = Vector3::Zero();  // rad
    for (int i = 0; i < 2000; ++i) {
      const Vector3 w = hand.omega(i * 0.01);
      forward += 0.01 * w.cwiseMax(0.0);
      backward -= 0.01 * w.cwiseMin(0.0);
    }
    EXPECT_GT(forward.minCoeff(), kTwoPi / 4);
    EXPECT_GT(backward.minCoeff(), kTwoPi / 4);
  }
}

// What calibration needs: gravity and the field from many sides. The scatter of n's axis z, seen
// from the sensor, has eigenvalues 1/3 each where every direction is equally frequent.
TEST(HandMotion, shows_the_vertical_from_all_sides_within_20_seconds) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const HandMotion hand(seed, 120.0, 3.0);
    const std::vector<Rot3> nRb = integrate(sampled(hand, 50.0, 20.0), 50.0);
    Matrix3 scatter = Matrix3::Zero();
    double count = 0.0;
    for (std::size_t k = 150; k < nRb.size(); ++k, count += 1.0) {
      const Vector3 up = nRb[k].matrix().row(2).transpose();
      scatter += up * up.transpose();
    }
    scatter /= count;
    // No direction d has a mean (d' up)^2 below 0.05: sampled over the sphere.
    for (int i = 0; i < 500; ++i) {
      const double z = (i + 0.5) / 500, azimuth = 2.399963 * i, r = std::sqrt(1 - z * z);
      const Vector3 d(r * std::cos(azimuth), r * std::sin(azimuth), z);
      ASSERT_GT(d.dot(scatter * d), 0.05) << "seed " << seed;
    }
  }
}

TEST(HandMotion, turns_at_the_rates_of_a_hand) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const HandMotion hand(seed, 120.0, 3.0);
    double inside = 0.0, moving = 0.0, fastest = 0.0;
    for (const auto& s : hand.stretches()) {
      for (int i = 100; i < 100 * (s.end - s.start) - 100; ++i) {  // but for the ramps
        const double speed = hand.omega(s.start + 0.01 * i).norm();
        moving += 1.0;
        inside += speed > 0.3 ? 1.0 : 0.0;
        fastest = std::max(fastest, speed);
      }
    }
    EXPECT_LE(fastest, 2.5);
    EXPECT_GT(fastest, 1.5);
    EXPECT_GT(inside / moving, 0.95);
  }
}

TEST(HandMotion, has_hardly_any_power_above_1_5_hertz) {
  const double step = 0.05;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const HandMotion hand(seed, 120.0, 3.0);
    double below = 0.0, above = 0.0;
    for (int m = 1; m < 1200; ++m) {  // discrete Fourier transform at m / 120 s, up to 10 Hz
      const std::complex<double> turn = std::polar(1.0, -kTwoPi * m / 2400.0);
      std::complex<double> phase = 1.0;
      Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
      for (int i = 0; i < 2400; ++i, phase *= turn) sum += phase * hand.omega(i * step);
      (m > 1.5 * 120 ? above : below) += sum.squaredNorm();
    }
    EXPECT_LT(above, 1e-3 * below) << "seed " << seed;
  }
}

// Yaw, pitch, roll first; each half a turn about its axis as a hand does it, then a rest.
TEST(TurnSequence, begins_with_half_turns_in_yaw_pitch_and_roll) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TurnSequence turns(seed, 63.0, 3.0);
    double t = 3.0;
    for (const Vector3& axis : {Vector3(0, 0, 1), Vector3(0, 1, 0), Vector3(1, 0, 0)}) {
      Vector3 angle = Vector3::Zero();
      double begin = t;
      while (turns.omega(t + 1e-3).norm() > 1e-9) {
        angle += 1e-3 * turns.omega(t += 1e-3);
        ASSERT_LT(t - begin, 5.0);
      }
      EXPECT_NEAR(angle.norm(), 0.5 * kTwoPi, 4.0 * 0.03 * 0.5 * kTwoPi);
      EXPECT_GT(angle.normalized().dot(axis), std::cos(0.25));
      for (begin = t; turns.omega(t + 1e-3).norm() < 1e-9; t += 1e-3) ASSERT_LT(t - begin, 1.0);
      EXPECT_NEAR(t - begin, 0.5, 0.05);
    }
    EXPECT_TRUE(turns.omega(1.5).isZero(0.0));
  }
}

TEST(TurnSequence, rate_has_the_derivative_that_it_tells) {
  const TurnSequence turns(3, 63.0, 3.0);
  constexpr double h = 1e-5;
  for (double t = 3.1; t < 60.0; t += 0.37) {
    const Vector3 numerical = (turns.omega(t + h) - turns.omega(t - h)) / (2.0 * h);
    EXPECT_LT((turns.omega_rate(t) - numerical).norm(), 1e-4) << t;
  }
}

// In a minute the sequence leaves no large part of the sphere of directions unseen by gravity.
TEST(TurnSequence, covers_the_sphere) {
  const TurnSequence turns(1, 63.0, 3.0);
  const AngularMotion motion = sample_motion(
      turns.initial_nRb(), [&](double t) { return turns.omega(t); }, 20.0, 63.0);
  const std::vector<Rot3> nRb = integrate(motion, 20.0);
  double farthest = 0.0;
  for (int i = 0; i < 200; ++i) {  // a spiral of even density
    const double z = 1.0 - 2.0 * (i + 0.5) / 200.0, around = 2.399963 * i;
    const Vector3 d(std::sqrt(1 - z * z) * std::cos(around),
                    std::sqrt(1 - z * z) * std::sin(around), z);
    double nearest = 2.0;
    for (const Rot3& R : nRb)
      nearest = std::min(nearest, (R.unrotate(Vector3::UnitZ()) - d).norm());
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 1.0);  // 60 deg
}

TEST(HandMotion, keeps_still_where_there_is_no_time_to_move) {
  const HandMotion hand(1, 2.0, 1.5);
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(hand.omega(0.01 * i).isZero(0.0));
}

}  // namespace
}  // namespace magimu
