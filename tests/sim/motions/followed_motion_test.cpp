// SPDX-License-Identifier: BSD-3-Clause
#include "sim/motions/followed_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/draws/random.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

// Nodes of a simulated hand, with the noise that an estimate has from one to the next.
EstimatedTrajectory estimated(const Simulation& s, double noise) {
  EstimatedTrajectory out;
  const std::size_t every = 4;
  RandomStream random(1, RandomPurpose::kEffectNoise);
  Rot3 error;
  const double dt = (s.truth.t[1] - s.truth.t[0]) * double(every);
  for (std::size_t k = 0; k < s.truth.t.size(); k += every) {
    out.t.push_back(s.truth.t[k]);
    out.nRb.push_back(s.truth.nRb[k] * error);
    if (!s.truth.p.empty()) {
      out.v.push_back(s.truth.v[k]);
      out.p.push_back(s.truth.p[k]);
    }
    error = error * Rot3::Exp(noise * std::sqrt(dt) * random.normal3());
  }
  out.rests = {{0.0, 2.9}};
  out.rate_density = noise;
  out.acceleration_density = 0.02;
  return out;
}

Simulation hand(SimulatedMotion motion) {
  SimulationOptions options;
  options.motion = motion;
  options.rate_hz = 100.0;
  options.duration_s = 30.0;
  options.seed = 3;
  return simulate(options);
}

TEST(FollowedMotion, is_the_motion_that_was_estimated_without_its_noise) {
  const Simulation s = hand(SimulatedMotion::kHandHeld);
  constexpr double kNoise = 1e-3;  // rad/s per sqrt(Hz)
  const EstimatedTrajectory e = estimated(s, kNoise);
  const FollowedMotion motion(e, 30.0);
  double rate = 0.0, raw = 0.0, place = 0.0;
  int n = 0;
  for (std::size_t k = 0; k + 1 < e.t.size(); ++k) {
    const double dt = e.t[k + 1] - e.t[k], middle = 0.5 * (e.t[k] + e.t[k + 1]);
    const std::size_t i = 4 * k;
    const Vector3 truth = (s.truth.nRb[i].inverse() * s.truth.nRb[i + 4]).Log() / dt;
    const Vector3 estimate = (e.nRb[k].inverse() * e.nRb[k + 1]).Log() / dt;
    rate += (motion.omega(middle) - truth).squaredNorm();
    raw += (estimate - truth).squaredNorm();
    place += (motion.position(e.t[k]) - e.p[k]).squaredNorm();
    ++n;
  }
  EXPECT_LT(rate, 0.5 * raw) << "knots are further apart than nodes";
  EXPECT_LT(std::sqrt(place / n), 2e-3);
  EXPECT_EQ(motion.omega(1.0), Vector3::Zero()) << "at rest";
}

TEST(FollowedMotion, gives_rates_and_accelerations_that_are_derivatives) {
  const Simulation s = hand(SimulatedMotion::kHandHeld);
  const FollowedMotion motion(estimated(s, 1e-3), 30.0);
  constexpr double h = 1e-4;
  for (const double t : {4.0, 11.3, 20.7, 29.5}) {
    const Vector3 rate = (motion.omega(t + h) - motion.omega(t - h)) / (2.0 * h);
    EXPECT_LT((motion.omega_rate(t) - rate).norm(), 1e-4 * (1.0 + rate.norm()));
    const Vector3 v = (motion.position(t + h) - motion.position(t - h)) / (2.0 * h);
    EXPECT_LT((motion.position(t, 1) - v).norm(), 1e-5 * (1.0 + v.norm()));
    const Vector3 a = (motion.position(t + h, 1) - motion.position(t - h, 1)) / (2.0 * h);
    EXPECT_LT((motion.position(t, 2) - a).norm(), 1e-3 * (1.0 + a.norm()));
  }
}

TEST(FollowedMotion, of_a_sensor_that_only_turns_stays_in_its_place) {
  const Simulation s = hand(SimulatedMotion::kHand);
  const FollowedMotion motion(estimated(s, 1e-3), 30.0);
  EXPECT_FALSE(motion.moves());
  EXPECT_EQ(motion.position(10.0, 2), Vector3::Zero());
}

}  // namespace
}  // namespace magimu
