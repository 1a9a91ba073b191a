// SPDX-License-Identifier: BSD-3-Clause
// The random numbers behind a simulation: the same everywhere, and distributed as they claim.
#include "sim/draws/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace magimu {
namespace {

constexpr int kDraws = 200000;

TEST(RandomStream, repeats_itself_and_differs_by_seed_purpose_and_index) {
  RandomStream a(7, RandomPurpose::kMotion), b(7, RandomPurpose::kMotion);
  RandomStream other_seed(8, RandomPurpose::kMotion);
  RandomStream other_purpose(7, RandomPurpose::kGyroscopeNoise);
  RandomStream other_index(7, RandomPurpose::kMotion, 1);
  for (int i = 0; i < 100; ++i) {
    const double x = a.normal();
    EXPECT_EQ(x, b.normal());
    EXPECT_NE(x, other_seed.normal());
    EXPECT_NE(x, other_purpose.normal());
    EXPECT_NE(x, other_index.normal());
  }
}

// A seed is the name of a data set: these numbers may not change, on any platform. They come from
// an implementation of the generator in another language.
TEST(RandomStream, draws_what_it_has_always_drawn) {
  RandomStream random(1, RandomPurpose::kMotion);
  EXPECT_EQ(random.uniform(), 0x1.5afec1c3242ddp-1);
  EXPECT_EQ(random.uniform(), 0x1.7a599499c24aep-2);
  EXPECT_NEAR(random.normal(), 0.9395450963013016, 1e-14);
}

TEST(RandomStream, uniform_numbers_fill_the_unit_interval_evenly) {
  RandomStream random(3, RandomPurpose::kMotion);
  std::vector<int> bins(20);
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    ++bins[static_cast<std::size_t>(u * 20)];
  }
  for (const int count : bins) EXPECT_NEAR(count, kDraws / 20.0, 5 * std::sqrt(kDraws / 20.0));
}

TEST(RandomStream, indices_hold_every_value_below_n_and_no_other) {
  RandomStream random(3, RandomPurpose::kMotion);
  std::vector<int> counts(3);
  for (int i = 0; i < 3000; ++i) ++counts.at(static_cast<std::size_t>(random.index(3)));
  for (const int count : counts) EXPECT_NEAR(count, 1000, 150);
}

TEST(RandomStream, normal_numbers_agree_with_the_normal_distribution_function) {
  RandomStream random(4, RandomPurpose::kMotion);
  std::vector<double> x(kDraws);
  for (double& value : x) value = random.normal();
  std::sort(x.begin(), x.end());
  double distance = 0.0;  // Kolmogorov and Smirnov's
  for (int i = 0; i < kDraws; ++i) {
    const double cdf = 0.5 * std::erfc(-x[static_cast<std::size_t>(i)] / std::sqrt(2.0));
    distance = std::max(distance, std::abs(cdf - (i + 0.5) / kDraws));
  }
  EXPECT_LT(distance * std::sqrt(kDraws), 1.95);  // exceeded once in a thousand
}

TEST(RandomStream, successive_normal_numbers_are_uncorrelated) {
  RandomStream random(5, RandomPurpose::kMotion);
  double product = 0.0, previous = random.normal();
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    product += previous * x;
    previous = x;
  }
  EXPECT_LT(std::abs(product) / std::sqrt(kDraws), 4.0);
}

}  // namespace
}  // namespace magimu
