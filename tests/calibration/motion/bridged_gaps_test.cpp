// SPDX-License-Identifier: BSD-3-Clause
// What bridging a gap costs.
#include "calibration/motion/bridged_gaps.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

VectorSeries every_10_ms(int count) {
  VectorSeries s;
  for (int k = 0; k < count; ++k) s.push_back(0.01 * k, Vector3(0.01 * k, 0.0, 0.0));
  return s;
}

TEST(GapVariances, are_none_without_gaps) {
  EXPECT_TRUE(gap_variances(every_10_ms(100), {0.0, 0.1, 0.5, 0.99}).empty());
}

TEST(GapVariances, are_what_the_held_rate_may_miss) {
  VectorSeries s = every_10_ms(100);
  // Samples 31 to 40 are lost; sample 30 tells of 0.30 to 0.31 s, and 0.1 s are not known.
  s.t.erase(s.t.begin() + 31, s.t.begin() + 41);
  s.v.erase(s.v.begin() + 31, s.v.begin() + 41);
  s.v[31] = s.v[30] + Vector3(0.0, 2.0, 0.0);  // rad/s
  const std::vector<double> one = gap_variances(s, {0.0, 0.2, 0.5, 0.9});
  ASSERT_EQ(one.size(), 3U);
  EXPECT_EQ(one[0], 0.0);
  EXPECT_NEAR(std::sqrt(3.0 * one[1]), 0.5 * 2.0 * 0.1, 1e-9);
  EXPECT_EQ(one[2], 0.0);
  const std::vector<double> two = gap_variances(s, {0.0, 0.36, 0.9});
  EXPECT_NEAR(std::sqrt(3.0 * two[0]), 0.05, 1e-9);
  EXPECT_NEAR(std::sqrt(3.0 * two[1]), 0.05, 1e-9);
}

TEST(GapVariances, become_densities) {
  EXPECT_EQ(with_gap(0.1, {}, 7, 0.5), 0.1);
  EXPECT_NEAR(with_gap(0.1, {0.0, 0.08}, 1, 0.5), std::sqrt(0.01 + 0.16), 1e-12);
}

}  // namespace
}  // namespace magimu
