// SPDX-License-Identifier: BSD-3-Clause
// Marks drawn for devices that differ, or do not.
#include "archive/same_device.h"

#include <gmock/gmock.h>

#include <random>

namespace magimu {
namespace {

// device: of each recording, in the order of time. apart: how far devices differ, and drift: how
// far a recording is from the one before, in standard deviations of one; scatter: as a multiple of
// the standard deviations that recordings claim.
std::vector<DeviceMark> draw_marks(const std::vector<std::size_t>& device, double apart,
                                   double scatter, std::uint64_t seed, double drift = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](Eigen::Index n) {
    VectorXd out(n);
    for (double& x : out) x = normal(random);
    return out;
  };
  std::vector<DeviceMark> out(device.size());
  for (std::size_t f = 0; f < out.front().parts.size(); ++f) {
    const Eigen::Index n = f == DeviceMark::kDistortion ? 8 : 3;
    const VectorXd first = apart * draw(n), second = apart * draw(n);
    VectorXd walk = VectorXd::Zero(n);
    for (std::size_t i = 0; i < device.size(); ++i) {
      walk += drift * draw(n);
      out[i].parts[f] = {(device[i] == 0 ? first : second) + walk + scatter * draw(n),
                         MatrixXd::Identity(n, n)};
    }
  }
  return out;
}

TEST(SameDevice, recordings_of_two_devices_in_turn_are_told) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto turns = groups_that_take_turns(draw_marks({0, 1, 0, 1, 0, 1}, 200.0, 3.0, seed));
    ASSERT_TRUE(turns) << seed;
    EXPECT_EQ(turns->groups, 2u);
    EXPECT_EQ(turns->turns, 5u);
    EXPECT_EQ(turns->group[0], turns->group[2]);
    EXPECT_NE(turns->group[0], turns->group[1]);
  }
}

TEST(SameDevice, one_device_is_not_doubted_whatever_its_recordings_scatter) {
  int doubted = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    for (const double scatter : {0.3, 1.0, 5.0}) {
      const std::vector<std::size_t> one(3 + seed % 8, 0);
      doubted += groups_that_take_turns(draw_marks(one, 200.0, scatter, seed)).has_value();
    }
  }
  EXPECT_LE(doubted, 2);
}

TEST(SameDevice, a_change_that_stays_and_a_drift_are_of_one_device) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_FALSE(groups_that_take_turns(draw_marks({0, 0, 0, 1, 1, 1}, 200.0, 1.0, seed)));
    const std::vector<std::size_t> one(20, 0);
    EXPECT_FALSE(groups_that_take_turns(draw_marks(one, 0.0, 1.0, seed, 20.0))) << seed;
  }
}

TEST(SameDevice, the_right_groups_have_the_evidence) {
  const auto marks = draw_marks({0, 0, 1, 1}, 100.0, 2.0, 5);
  EXPECT_GT(log_factor_of_groups(marks, {0, 0, 1, 1}), log_factor_that_decides());
  EXPECT_LT(log_factor_of_groups(marks, {0, 1, 0, 1}), log_factor_that_decides());
  // By themselves, groups of one say nothing.
  EXPECT_EQ(log_factor_of_groups(marks, {0, 1, 2, 3}), 0.0);
}

}  // namespace
}  // namespace magimu
