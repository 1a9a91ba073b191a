// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/repeats.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/draws/random.h"

namespace magimu {
namespace {

// Turns for a minute and rests for half of one; every nth sample is the one before.
VectorSeries samples(double step, int nth) {
  RandomStream random(1, RandomPurpose::kMotion);
  VectorSeries out;
  for (int k = 0; k < 9000; ++k) {
    const double t = k / 100.0, phase = t < 60.0 ? t : 60.0;
    Vector3 v = 40.0 * Vector3(std::sin(phase), std::cos(0.7 * phase), std::sin(1.3 * phase)) +
                0.2 * random.normal3();
    if (step > 0.0) v = (v / step).array().round() * step;
    if (nth > 0 && k % nth == 1) v = out.v.back();
    out.push_back(t, v);
  }
  return out;
}

TEST(Repeats, are_counted) {
  const Repeats fine = repeats_in(samples(0.0, 50));
  EXPECT_EQ(fine.seen, 180u);
  EXPECT_LT(fine.expected, 1.0);
  EXPECT_TRUE(fine.beyond_chance());
  EXPECT_TRUE(repeats_in(samples(0.15, 50)).beyond_chance());
}

TEST(Repeats, there_are_none_in_noise) {
  EXPECT_EQ(repeats_in(samples(0.0, 0)).seen, 0u);
  EXPECT_FALSE(repeats_in(samples(0.0, 0)).beyond_chance());
  EXPECT_EQ(repeats_in({}).seen, 0u);
}

// Steps of up to three times the noise: at rest, samples repeat by chance.
TEST(Repeats, of_a_coarse_quantization_are_chance) {
  for (const double step : {0.1, 0.15, 0.3, 0.6}) {
    const Repeats coarse = repeats_in(samples(step, 0));
    EXPECT_FALSE(coarse.beyond_chance())
        << step << ": " << coarse.seen << " of " << coarse.expected;
  }
  EXPECT_EQ(repeats_in(samples(0.6, 0)).seen, 0u) << "nothing is counted where it is common";
}

// Most changes are then smaller than their root mean square says.
TEST(Repeats, of_quantized_noise_with_far_tails_are_chance) {
  RandomStream random(2, RandomPurpose::kMotion);
  for (const double step : {0.02, 0.05, 0.1, 0.2}) {
    VectorSeries series;
    for (int k = 0; k < 20000; ++k) {
      const double size = random.normal3()[0] > 1.5 ? 2.0 : 0.2;
      const Vector3 v = size * random.normal3();
      series.push_back(k / 100.0, (v / step).array().round() * step);
    }
    EXPECT_FALSE(repeats_in(series).beyond_chance()) << step;
  }
}

}  // namespace
}  // namespace magimu
