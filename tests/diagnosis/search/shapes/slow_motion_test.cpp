// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/slow_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/search/doubts.h"

namespace magimu {
namespace {

constexpr double kNode = 0.1;  // s

// Noise of size 1 that remembers a node by rho; a motion of so much at 0.7 Hz in the long piece.
NodeResiduals residuals_with(double rho, double motion, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  NodeResiduals out;
  out.interval_s = kNode;
  const auto piece = [&](int nodes, double amplitude) {
    std::vector<Vector3> x;
    Vector3 before = Vector3::Zero();
    for (int k = 0; k < nodes; ++k) {
      const Vector3 fresh(normal(random), normal(random), normal(random));
      before = k == 0 ? fresh : Vector3(rho * before + std::sqrt(1.0 - rho * rho) * fresh);
      const double phase = 2.0 * M_PI * 0.7 * k * kNode;
      x.push_back(before +
                  amplitude * Vector3(std::sin(phase), std::cos(phase), std::sin(phase + 1.0)));
    }
    return x;
  };
  out.still = {piece(40, 0.0), piece(40, 0.0)};
  out.moving = {piece(1000, motion)};
  return out;
}

TEST(SlowPower, is_that_of_noise_where_nothing_moves_white_or_coloured) {
  for (const double rho : {0.0, 0.8}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      EXPECT_LT(slow_power(residuals_with(rho, 0.0, seed)).z(), 4.0) << rho << ", seed " << seed;
    }
  }
}

TEST(SlowPower, finds_a_motion_far_below_the_noise_of_single_nodes) {
  int found = 0;  // where the rests by chance look coloured, it is not
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SlowPower p = slow_power(residuals_with(0.0, 0.5, seed));
    if (p.z() < 4.5) continue;
    ++found;
    // 1000 nodes of three axes with the mean square of such a sine.
    EXPECT_NEAR(p.squares, 3000 * 0.5 * 0.25, 120.0) << "seed " << seed;
  }
  EXPECT_GE(found, 9);
}

TEST(SlowPower, tells_a_motion_from_colour_by_what_is_slower_still) {
  int motions = 0, colours = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    motions += slow_power(residuals_with(0.0, 0.4, seed)).over_coloured() > 1.4;
    colours += slow_power(residuals_with(0.8, 0.0, seed)).over_coloured() > 1.4;
  }
  EXPECT_GE(motions, 18);
  EXPECT_EQ(colours, 0);
}

TEST(SlowPower, does_not_take_blows_for_a_motion) {
  NodeResiduals r = residuals_with(0.0, 0.0, 1);
  for (std::size_t k = 0; k < r.moving[0].size(); k += 29) r.moving[0][k] += Vector3(8, -8, 5);
  EXPECT_LT(slow_power(r).z(), 4.0);
}

TEST(SlowPower, says_nothing_without_a_rest) {
  NodeResiduals r = residuals_with(0.0, 2.0, 1);
  r.still.clear();
  EXPECT_EQ(slow_power(r).unknowns, 0.0);
}

// Two rests of four seconds between turns, the noise as above.
Recording resting(double rho, double density, double shake_at_the_ends, std::uint64_t seed) {
  constexpr double kSamplesPerSecond = 100.0;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Recording out;
  Vector3 gyr = Vector3::Zero(), acc = Vector3::Zero();
  const auto next = [&](Vector3& x) {
    const Vector3 fresh(normal(random), normal(random), normal(random));
    x = rho * x + std::sqrt(1.0 - rho * rho) * fresh;
    return Vector3(density * std::sqrt(kSamplesPerSecond) * x);
  };
  for (int k = 0; k < int(20 * kSamplesPerSecond); ++k) {
    const double t = k / kSamplesPerSecond;
    const bool moving = t > 5.0 && t<15.0, shaken = t> 4.2 && t < 15.8;
    const double shake = shaken ? shake_at_the_ends * std::sin(5.0 * t) : 0.0;
    out.gyr.t.push_back(t);
    out.gyr.v.push_back(next(gyr) + (moving ? 1.0 : 0.0) * Vector3(1.0, 0.5, -0.5));
    out.acc.t.push_back(t);
    out.acc.v.push_back(next(acc) + Vector3(shake, 0.0, 9.8));
  }
  return out;
}

constexpr double kDensity = 1e-4;
constexpr NoiseDensities kWhiteNoise{kDensity, kDensity, 0.0};

TEST(SlowNoise, of_white_noise_is_that_of_its_samples) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Recording r = resting(0.0, kDensity, 0.0, seed);
    const SlowNoise slow = slow_noise_at_rest({&r});
    EXPECT_EQ(slow.excess(Sensor::kAcc, kWhiteNoise), 1.0) << "seed " << seed;
    EXPECT_EQ(slow.excess(Sensor::kGyr, kWhiteNoise), 1.0) << "seed " << seed;
    EXPECT_NEAR(slow.gyr, kDensity, 0.6 * kDensity) << "seed " << seed;
  }
}

TEST(SlowNoise, of_coloured_noise_is_larger) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Recording r = resting(0.95, kDensity, 0.0, seed);
    EXPECT_GT(slow_noise_at_rest({&r}).excess(Sensor::kGyr, kWhiteNoise), 5.0) << "seed " << seed;
  }
}

// A first difference of its means would be three times as large as noise makes it.
TEST(SlowNoise, of_a_sensor_that_warms_up_is_no_larger) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Recording r = resting(0.0, kDensity, 0.0, seed);
    for (VectorSeries* s : {&r.acc, &r.gyr}) {
      for (std::size_t k = 0; k < s->size(); ++k) {
        s->v[k] += 5.0 * kDensity * s->t[k] * Vector3(0.6, -0.8, 0.0);
      }
    }
    const SlowNoise slow = slow_noise_at_rest({&r});
    EXPECT_EQ(slow.excess(Sensor::kAcc, kWhiteNoise), 1.0) << "seed " << seed;
    EXPECT_EQ(slow.excess(Sensor::kGyr, kWhiteNoise), 1.0) << "seed " << seed;
  }
}

TEST(SlowNoise, does_not_count_what_the_hand_does_where_a_rest_ends) {
  const Recording r = resting(0.0, kDensity, 0.05, 1);
  EXPECT_EQ(slow_noise_at_rest({&r}).excess(Sensor::kAcc, kWhiteNoise), 1.0);
}

// Ten seconds of rest, so long a turn, ten of rest; the bias wanders with this density.
Recording wandering(double density, double turn_s, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Recording out;
  Vector3 bias = Vector3::Zero();
  for (double t = 0.0; t < 20.0 + turn_s; t += 0.01) {
    const bool turning = t > 10.0 && t < 10.0 + turn_s;
    const auto next = [&](double scale) -> Vector3 {
      return scale * Vector3(normal(random), normal(random), normal(random));
    };
    bias += next(density * 0.1);
    out.gyr.t.push_back(t);
    out.gyr.v.push_back(bias + next(kDensity * 10.0) + (turning ? 0.5 : 0.0) * Vector3::Ones());
    out.acc.t.push_back(t);
    out.acc.v.push_back(next(kDensity * 10.0) + Vector3(0.0, 0.0, 9.8));
  }
  return out;
}

TEST(Rests, contradict_a_walk_that_is_not_there) {
  const Recording r = wandering(0.0, 10.0, 1);
  EXPECT_TRUE(rests_contradict_walk({&r}, 20.0 * kDensity));
  EXPECT_FALSE(rests_contradict_walk({&r}, kDensity));
}

// Within each rest the noise hides so small a walk; not from the first to the last.
TEST(Rests, contradict_a_small_walk_by_what_is_the_same_a_minute_later) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Recording r = wandering(0.0, 100.0, seed);
    EXPECT_TRUE(rests_contradict_walk({&r}, 4.0 * kDensity)) << "seed " << seed;
  }
}

TEST(Rests, do_not_contradict_a_walk_that_is_there) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const double density = kDensity * (seed % 3 == 0 ? 10.0 : seed % 3 == 1 ? 1.0 : 0.1);
    const Recording r = wandering(density, 20.0, seed);
    EXPECT_FALSE(rests_contradict_walk({&r}, 1.5 * density)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace magimu
