// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/blows.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

// A minute at 250 Hz; accelerations of `size` m/s^2 at 113 Hz, and `taps`.
Recording minute(double size, int taps) {
  Recording r;
  for (int k = 0; k < 15000; ++k) {
    const double t = 0.004 * k, vibration = size * std::sin(2.0 * M_PI * 113.0 * t);
    const double tap = taps > 0 && k % (15000 / taps) == 500 ? 100.0 : 0.0;
    r.acc.push_back(t, Vector3(vibration, tap, 9.8));
    r.gyr.push_back(t, Vector3::Zero());
  }
  return r;
}

TEST(Blows, are_no_vibration_that_is_there_all_the_time) {
  EXPECT_EQ(blows_per_minute(minute(6.0, 0)), 0.0);
  EXPECT_EQ(blows_per_minute(minute(30.0, 0)), 0.0);
}

TEST(Blows, are_counted_beside_a_vibration) {
  EXPECT_NEAR(blows_per_minute(minute(6.0, 10)), 10.0, 0.01);
  EXPECT_NEAR(blows_per_minute(minute(0.0, 10)), 10.0, 0.01);
}

}  // namespace
}  // namespace magimu
