// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/jump_sizes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace magimu {
namespace {

constexpr double kLeast = 6.0, kMost = 400.0;

void add_tail(JumpSizes& sizes, double K, int of, std::mt19937& bits, double& largest) {
  std::normal_distribution<double> noise(0.0, K);
  for (int i = 0; i < of; ++i) {
    const double u =
        std::max({std::abs(noise(bits)), std::abs(noise(bits)), std::abs(noise(bits))});
    if (u < kLeast) continue;
    sizes.add(u);
    largest = std::max(largest, u);
  }
}

TEST(JumpSizes, a_few_readings_are_no_tail) {
  JumpSizes sizes;
  EXPECT_EQ(sizes.end_of_tail(kLeast, kMost), 0.0);
  for (const double u : {7.0, 9.0, 30.0, 80.0}) sizes.add(u);
  EXPECT_EQ(sizes.end_of_tail(kLeast, kMost), 0.0);
}

TEST(JumpSizes, a_tail_of_the_noise_ends_beyond_all_of_it) {
  std::mt19937 bits(1);
  for (const double K : {4.0, 10.0, 30.0}) {
    for (const int of : {30, 300}) {
      for (int trial = 0; trial < 20; ++trial) {
        JumpSizes sizes;
        double largest = 0.0;
        add_tail(sizes, K, of, bits, largest);
        if (sizes.size() < 8) continue;
        EXPECT_GT(sizes.end_of_tail(kLeast, kMost), largest) << K << ' ' << of;
        EXPECT_LT(sizes.end_of_tail(kLeast, kMost), 12.0 * K) << K << ' ' << of;
      }
    }
  }
}

TEST(JumpSizes, garbage_is_no_tail_and_does_not_hide_one) {
  std::mt19937 bits(2);
  std::uniform_real_distribution<double> any(60.0, kMost);
  for (int trial = 0; trial < 20; ++trial) {
    JumpSizes sizes;
    for (int i = 0; i < 15; ++i) sizes.add(any(bits));
    EXPECT_LT(sizes.end_of_tail(kLeast, kMost), 100.0);
    double largest = 0.0;
    add_tail(sizes, 8.0, 60, bits, largest);
    EXPECT_GT(sizes.end_of_tail(kLeast, kMost), largest);
    EXPECT_LT(sizes.end_of_tail(kLeast, kMost), 60.0);
  }
}

}  // namespace
}  // namespace magimu
