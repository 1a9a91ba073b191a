// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/numbers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu::apps {
namespace {

TEST(Numbers, have_two_figures_of_their_uncertainty) {
  EXPECT_EQ(with_sigma(0.0110432, 0.000081), "0.011043 ± 0.000081");
  EXPECT_EQ(with_sigma(-512.4, 31.0), "-512 ± 31");
  EXPECT_EQ(with_sigma(0.3, 5.7e-6), "0.3000000 ± 0.0000057");
  EXPECT_EQ(with_sigma(1.234e-8, 4.1e-10), "(1.234 ± 0.041)e-8");
  EXPECT_EQ(with_sigma(0.00999999999, 1e-12), "0.01");
  EXPECT_EQ(with_sigma(0.0, 2.5e-9), "(0.0 ± 2.5)e-9");
}

TEST(Numbers, without_uncertainty_have_four_figures) {
  EXPECT_EQ(with_sigma(1.23456, NAN), "1.235");
  EXPECT_EQ(with_sigma(1.23456, 0.0), "1.235");
  EXPECT_EQ(plain(INFINITY), "-");
  EXPECT_EQ(with_sigma(NAN, 1.0), "-");
}

TEST(Numbers, of_probability_claim_no_certainty) {
  EXPECT_EQ(percent(1.0), "more than 99.9 %");
  EXPECT_EQ(percent(0.0), "less than 0.1 %");
  EXPECT_EQ(percent(0.97), "97 %");
  EXPECT_EQ(percent(0.01), "1 %");
  EXPECT_EQ(percent(0.996), "99.6 %");
}

}  // namespace
}  // namespace magimu::apps
