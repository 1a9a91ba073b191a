// SPDX-License-Identifier: BSD-3-Clause
// Errors that grow with the rate of turning against noise of every kind that does not.
#include "diagnosis/noise/noise_by_rate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace magimu {
namespace {

constexpr double kRate_hz = 50.0, kDuration_s = 120.0;

// A hand that turns faster and slower: 0 to 2 rad/s within some seconds.
Recording turning() {
  Recording out;
  for (double t = 0.0; t < kDuration_s; t += 1.0 / kRate_hz) {
    out.gyr.push_back(t, Vector3(1.0 + std::sin(0.8 * t), 0.0, 0.0));
  }
  return out;
}

using Noise = std::function<double(std::mt19937_64&, double rate, double& state)>;

NoiseByRate seen_in(const Noise& noise, std::uint64_t seed) {
  const Recording recording = turning();
  std::mt19937_64 random(seed);
  ResidualSeries series;
  Vector3 state = Vector3::Zero();
  for (std::size_t k = 0; k < recording.gyr.size(); ++k) {
    Vector3 r;
    for (int i = 0; i < 3; ++i) r[i] = noise(random, recording.gyr.v[k][0], state[i]);
    series.t.push_back(recording.gyr.t[k]);
    series.whitened.push_back(r);
  }
  return noise_by_rate(series, recording);
}

double normal(std::mt19937_64& random) { return std::normal_distribution<double>()(random); }

const Noise kNoiseWhite = [](std::mt19937_64& random, double, double&) { return normal(random); };
const Noise kNoiseColoured = [](std::mt19937_64& random, double, double& x) {
  x = 0.95 * x + std::sqrt(1.0 - 0.95 * 0.95) * normal(random);
  return x;
};
const Noise kNoiseHeavyTailed = [](std::mt19937_64& random, double, double&) {
  return normal(random) * (random() % 100 == 0 ? 20.0 : 1.0);
};

TEST(NoiseByRate, holds_its_level_on_noise_of_any_kind) {
  for (const Noise& noise : {kNoiseWhite, kNoiseColoured, kNoiseHeavyTailed}) {
    int below = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) below += seen_in(noise, seed).log10_p < -2.0;
    EXPECT_LE(below, 7);  // 2 expected; more than 7 has a probability of 0.1 %
  }
}

TEST(NoiseByRate, finds_errors_that_turning_makes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const NoiseByRate seen =
        seen_in([](std::mt19937_64& random, double rate,
                   double&) { return normal(random) + 0.6 * rate * normal(random); },
                seed);
    EXPECT_LT(seen.log10_p, -5.0);
    EXPECT_GT(seen.statistic, 50.0);
    EXPECT_NEAR(seen.fast_over_slow, 1.45, 0.15);
  }
}

TEST(NoiseByRate, has_nothing_to_say_of_noise_that_falls_with_the_rate_or_of_few_samples) {
  const NoiseByRate falls = seen_in(
      [](std::mt19937_64& random, double rate, double&) { return normal(random) / (1.0 + rate); },
      1);
  EXPECT_EQ(falls.log10_p, 0.0);
  EXPECT_LT(falls.fast_over_slow, 1.0);
  ResidualSeries few;
  for (int k = 0; k < 50; ++k) {
    few.t.push_back(0.02 * k);
    few.whitened.push_back(Vector3::Ones());
  }
  EXPECT_EQ(noise_by_rate(few, turning()).log10_p, 0.0);
}

}  // namespace
}  // namespace magimu
