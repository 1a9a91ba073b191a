// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/result/sentence_words.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

TEST(SentenceNumbers, have_the_figures_that_their_uncertainty_leaves_standing) {
  EXPECT_EQ(value_and_sigma(121.03, 1.38), "121.0 +- 1.4");
  EXPECT_EQ(value_and_sigma(-0.00693, 0.292), "-0.01 +- 0.29");
  EXPECT_EQ(value_and_sigma(1234.4, 310.0), "1234 +- 310");
  EXPECT_EQ(value_and_sigma(2.5, NAN), "2.5");
}

TEST(SentenceNumbers, need_no_power_of_ten) {
  EXPECT_EQ(two_figures(254.0), "250");
  EXPECT_EQ(two_figures(0.731), "0.73");
  EXPECT_EQ(two_figures(99.7), "100");
  EXPECT_EQ(two_figures(INFINITY), "inf");
}

TEST(SentenceNumbers, agree_with_their_noun) {
  EXPECT_EQ(nats(1.2), "1 nat");
  EXPECT_EQ(nats(14.0), "14 nats");
  EXPECT_EQ(nats(0.2), "0 nats");
}

TEST(SentenceNumbers, name_an_effect_by_its_sensor) {
  EXPECT_EQ(effect_words("gyro_scale_misalignment"), "gyroscope scale misalignment");
  EXPECT_EQ(effect_words("outliers"), "outliers");
}

}  // namespace
}  // namespace magimu
