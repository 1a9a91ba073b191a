// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/change_search.h"
#include "statistics/tails.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace magimu {
namespace {

// The largest statistic of all spans of windows of white noise of three axes, their mean (the bias
// itself) eliminated: of those that last until the end, and of those that end before.
struct Largest {
  double lasting = 0.0, ended = 0.0;
};

Largest largest(int windows, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  MatrixXd sums = MatrixXd::Zero(3, windows + 1);
  for (int w = 0; w < windows; ++w) {
    for (int axis = 0; axis < 3; ++axis) sums(axis, w + 1) = sums(axis, w) + normal(random);
  }
  const Vector3 mean = sums.col(windows) / windows;
  for (int w = 1; w <= windows; ++w) sums.col(w) -= w * mean;
  Largest most;
  for (int a = 1; a < windows; ++a) {
    for (int b = a + 1; b <= windows; ++b) {
      const double length = b - a, variance = length * (1.0 - length / windows);
      const double statistic = (sums.col(b) - sums.col(a)).squaredNorm() / variance;
      double& of_kind = b == windows ? most.lasting : most.ended;
      of_kind = std::max(of_kind, statistic);
    }
  }
  return most;
}

// By the probabilities that a change is named by, how many of `drawn` recordings show one.
class SpansOfWindows : public testing::TestWithParam<int> {};

TEST_P(SpansOfWindows, count_as_so_many_tests_that_white_noise_alarms_as_often_as_it_should) {
  constexpr int kDrawn = 60000;
  constexpr double kLevel = 0.01;
  const int windows = GetParam();
  std::mt19937_64 random(7);
  int lasting = 0, ended = 0;
  for (int i = 0; i < kDrawn; ++i) {
    const Largest most = largest(windows, random);
    const auto p = [](double statistic) {
      return std::pow(10.0, log10_chi_square_tail(statistic, 3.0));
    };
    lasting += lasting_spans(windows) * p(most.lasting) < kLevel;
    ended += ended_spans(windows) * p(most.ended) < kLevel;
  }
  for (const int alarms : {lasting, ended}) {
    EXPECT_GT(alarms, 0.6 * kLevel * kDrawn);
    EXPECT_LT(alarms, 1.3 * kLevel * kDrawn);
  }
}

INSTANTIATE_TEST_SUITE_P(Change, SpansOfWindows, testing::Values(8, 12, 24),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace magimu
