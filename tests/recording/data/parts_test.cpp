// SPDX-License-Identifier: BSD-3-Clause
// Where a recording falls into parts.
#include "recording/data/parts.h"

#include <gmock/gmock.h>

#include <cmath>

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A minute of turning to and fro: rates of this size, one swing in this many seconds.
Recording turning(double rate_rad_s, double period_s, double hz = 100.0) {
  Recording r;
  r.name = "turning";
  r.mag.emplace_back();
  r.mag_names = {"mag"};
  for (int k = 0; k < int(60.0 * hz); ++k) {
    const double t = k / hz, w = 2.0 * M_PI * t / period_s;
    r.gyr.push_back(t, rate_rad_s * Vector3(std::sin(w), std::cos(0.7 * w), std::sin(1.3 * w)));
    r.acc.push_back(t, Vector3(0.0, 0.1 * std::sin(w), 9.8));
    r.mag[0].push_back(t, Vector3(20.0 * std::sin(w), 20.0 * std::cos(w), -40.0));
  }
  return r;
}

void cut_out(VectorSeries& s, double begin, double end) {
  VectorSeries kept;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.t[k] < begin || s.t[k] >= end) kept.push_back(s.t[k], s.v[k]);
  }
  s = kept;
}
Recording with_hole(Recording r, double begin, double end) {
  for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) cut_out(*s, begin, end);
  return r;
}

TEST(Parts, of_a_recording_without_gaps_are_none) {
  std::vector<std::string> warnings;
  EXPECT_FALSE(parts_of(turning(1.0, 2.0), warnings).has_value());
  EXPECT_THAT(warnings, IsEmpty());
}

TEST(Parts, lie_between_long_gaps_and_continue_the_first) {
  std::vector<std::string> warnings;
  const Recording whole = with_hole(with_hole(turning(1.0, 2.0), 20.0, 25.0), 40.0, 86440.0);
  const auto parts = parts_of(whole, warnings);
  ASSERT_TRUE(parts.has_value());
  ASSERT_EQ(parts->size(), 2U);
  EXPECT_FALSE(parts->at(0).continues_previous);
  EXPECT_TRUE(parts->at(1).continues_previous);
  EXPECT_EQ(parts->at(1).name, "turning");
  EXPECT_EQ(parts->at(0).gyr.size() + parts->at(1).gyr.size(), whole.gyr.size());
  EXPECT_NEAR(parts->at(1).gyr.t.front(), 25.0, 1e-9);
  EXPECT_EQ(parts->at(1).mag[0].t.front(), parts->at(1).gyr.t.front());
}

TEST(Parts, a_gap_is_bridged_as_far_as_the_motion_lets) {
  // Slow turns go on as they were, fast ones are anywhere after a fifth of a second.
  EXPECT_EQ(longest_bridge(turning(0.05, 10.0)), kLongestBridge);
  const double fast = longest_bridge(turning(3.0, 1.0)), hand = longest_bridge(turning(1.5, 3.0));
  EXPECT_LT(fast, 0.15);
  EXPECT_GT(hand, fast);
  EXPECT_LT(hand, 0.5);
  std::vector<std::string> warnings;
  EXPECT_TRUE(parts_of(with_hole(turning(3.0, 1.0), 20.0, 20.3), warnings).has_value());
  EXPECT_FALSE(parts_of(with_hole(turning(0.05, 10.0), 20.0, 20.3), warnings).has_value());
  EXPECT_TRUE(parts_of(with_hole(turning(0.05, 10.0), 20.0, 21.5), warnings).has_value());
}

TEST(Parts, of_a_slow_sensor_are_not_its_intervals) {
  std::vector<std::string> warnings;
  EXPECT_FALSE(parts_of(turning(3.0, 1.0, 5.0), warnings).has_value());
}

TEST(Parts, a_gap_of_one_inertial_sensor_parts_all_and_one_of_the_magnetometer_none) {
  std::vector<std::string> warnings;
  Recording acc = turning(1.0, 2.0), mag = acc;
  cut_out(acc.acc, 20.0, 23.0);
  cut_out(mag.mag[0], 20.0, 23.0);
  const auto parts = parts_of(acc, warnings);
  ASSERT_TRUE(parts.has_value());
  ASSERT_EQ(parts->size(), 2U);
  EXPECT_LT(parts->at(0).gyr.t.back(), 20.0);
  EXPECT_NEAR(parts->at(1).gyr.t.front(), 23.0, 1e-9);
  EXPECT_FALSE(parts_of(mag, warnings).has_value());
}

TEST(Parts, where_one_inertial_sensor_is_alone_are_left_out) {
  std::vector<std::string> warnings;
  Recording late = turning(1.0, 2.0);
  cut_out(late.acc, 0.0, 20.0);
  const auto parts = parts_of(late, warnings);
  ASSERT_TRUE(parts.has_value());
  ASSERT_EQ(parts->size(), 1U);
  EXPECT_NEAR(parts->front().gyr.t.front(), 20.0, 1e-9);
  EXPECT_FALSE(parts->front().continues_previous);
}

TEST(Parts, too_short_to_tell_anything_are_left_out_with_a_warning) {
  std::vector<std::string> warnings;
  const auto parts =
      parts_of(with_hole(with_hole(turning(1.0, 2.0), 20.0, 25.0), 25.5, 30.0), warnings);
  ASSERT_TRUE(parts.has_value());
  EXPECT_EQ(parts->size(), 2U);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("25.00-25.49 s")));
}

}  // namespace
}  // namespace magimu
