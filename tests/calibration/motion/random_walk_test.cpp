// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/random_walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace magimu {
namespace {

constexpr int kAmplitudes = 24;

// Score of amplitudes with the information A = diag(a), noise `excess` times as large in variance
// as A says, and a walk of that density in them.
struct Seen {
  MatrixXd A;
  VectorXd z, unit;
};

Seen seen(double density, double excess, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Seen out{MatrixXd::Zero(kAmplitudes, kAmplitudes), VectorXd(kAmplitudes), VectorXd(kAmplitudes)};
  for (int i = 0; i < kAmplitudes; ++i) {
    const double a = 50.0 + 10.0 * (i % 5);
    out.unit[i] = 3.0 / (1 + i / 3);
    out.A(i, i) = a;
    out.z[i] = std::sqrt(excess * a) * normal(random) + a * density * out.unit[i] * normal(random);
  }
  return out;
}

TEST(RandomWalk, of_white_noise_is_none) {
  int false_alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Seen s = seen(0.0, 1.0, seed);
    false_alarms += estimate_random_walk(s.A, s.z, s.unit).log10_p < -2.0 ? 1 : 0;
  }
  EXPECT_LE(false_alarms, 7);
}

TEST(RandomWalk, has_its_density) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Seen s = seen(0.3, 1.0, seed);
    const RandomWalk walk = estimate_random_walk(s.A, s.z, s.unit);
    EXPECT_NEAR(walk.density, 0.3, 5.0 * walk.sigma) << "seed " << seed;
    sum += walk.density / 50.0;
  }
  EXPECT_NEAR(sum, 0.3, 0.04);
}

TEST(RandomWalk, is_not_made_by_noise_that_is_known_to_be_larger) {
  int taken_for_one = 0, false_alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Seen s = seen(0.0, 9.0, seed);
    taken_for_one += estimate_random_walk(s.A, s.z, s.unit).log10_p < -2.0 ? 1 : 0;
    false_alarms += estimate_random_walk(s.A, s.z, s.unit, 9.0).log10_p < -2.0 ? 1 : 0;
  }
  EXPECT_GE(taken_for_one, 150);
  EXPECT_LE(false_alarms, 7);
}

}  // namespace
}  // namespace magimu
