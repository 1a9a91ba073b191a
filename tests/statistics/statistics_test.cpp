// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "statistics/golden_section.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

TEST(Quantile, is_the_number_at_its_place_in_order) {
  const std::vector<double> five{5.0, 1.0, 4.0, 2.0, 3.0};
  EXPECT_EQ(quantile(five, 0.0), 1.0);
  EXPECT_EQ(quantile(five, 0.5), 3.0);
  EXPECT_EQ(quantile(five, 0.75), 4.0);
  EXPECT_EQ(quantile(five, 1.0), 5.0);  // at most the last
  EXPECT_EQ(quantile(std::vector<int>{4, 2}, 0.5), 4);
  EXPECT_EQ(quantile(std::vector<double>{}, 0.5), 0.0);
}

TEST(Median, of_an_even_number_is_the_mean_of_the_two_in_the_middle) {
  EXPECT_EQ(median({4.0, 1.0, 2.0, 9.0}), 3.0);
  EXPECT_EQ(median({4.0, 1.0, 9.0}), 4.0);
  EXPECT_EQ(median({}), 0.0);
}

TEST(Tails, of_chi_square_agree_with_each_other_and_with_tables) {
  EXPECT_NEAR(chi_square_tail(3.841458820694124, 1), 0.05, 1e-12);
  EXPECT_NEAR(chi_square_tail(16.811893829770927, 6), 0.01, 1e-12);
  for (const int dof : {1, 2, 3, 8, 31}) {
    for (const double x : {0.1, 1.0, 10.0, 90.0}) {
      EXPECT_NEAR(std::log10(chi_square_tail(x, dof)), log10_chi_square_tail(x, dof), 1e-9)
          << x << " " << dof;
    }
  }
  EXPECT_EQ(log10_chi_square_tail(0.0, 3.0), 0.0);
}

// Where the tail itself is no number any more its logarithm goes on smoothly.
TEST(Tails, of_chi_square_go_on_where_doubles_end) {
  const double near = log10_chi_square_tail(1300.0, 3.0), far = log10_chi_square_tail(1302.0, 3.0);
  EXPECT_LT(far, near);
  EXPECT_NEAR(near - far, 1.0 / std::log(10.0), 1e-2);  // exp(-x/2)
  EXPECT_TRUE(std::isfinite(log10_chi_square_tail(1e9, 3.0)));
}

TEST(Tails, of_the_normal_are_the_chi_squares_of_one) {
  for (const double x : {0.5, 1.96, 5.0}) {
    EXPECT_NEAR(2.0 * normal_tail(x), chi_square_tail(x * x, 1), 1e-14);
  }
}

TEST(Tails, of_student_approach_the_normal_and_are_heavier) {
  EXPECT_NEAR(log10_student_tail(2.0, 1e7), std::log10(normal_tail(2.0)), 1e-6);
  EXPECT_GT(log10_student_tail(6.0, 4.0), std::log10(normal_tail(6.0)));
  EXPECT_GE(log10_student_tail(1e300, 400.0), -300.0);
}

TEST(GoldenSection, finds_the_least_value) {
  const auto f = [](double x) { return std::cosh(x - 0.3); };
  EXPECT_NEAR(golden_section_minimum(-2.0, 5.0, 1e-6, f), 0.3, 1e-6);
}

TEST(GoldenSection, ends_whatever_the_interval) {
  const auto f = [](double x) { return x; };
  EXPECT_NEAR(golden_section_minimum(0.0, 1.0, 0.0, f), 0.0, 1e-15);
  EXPECT_TRUE(
      std::isnan(golden_section_minimum(std::numeric_limits<double>::quiet_NaN(), 1.0, 1e-3, f)));
}

}  // namespace
}  // namespace magimu
