// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/time_likelihood.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

// Gains over the time in the middle, as a scan gives them.
template <class Gain>
LikelyTimes grid_about(double middle, double grid_s, int to_each_side, const Gain& gain) {
  LikelyTimes out = {.grid_s = grid_s};
  for (int i = -to_each_side; i <= to_each_side; ++i) {
    const double t = middle + i * grid_s;
    out.t.push_back(t);
    out.gain.push_back(gain(t) - gain(middle));
  }
  return out;
}

TEST(TimeLikelihood, of_one_grid_is_its_density) {
  constexpr double kSigma = 0.3, kMean = 12.1;
  TimeLikelihood likelihood;
  EXPECT_EQ(likelihood.width_s(), 0.0);
  likelihood.take(grid_about(12.0, 0.05, 60,
                             [](double t) { return -0.5 * std::pow((t - kMean) / kSigma, 2); }));
  EXPECT_NEAR(likelihood.sigma_s(), kSigma, 1e-3);
  EXPECT_NEAR(likelihood.width_s(), std::sqrt(2.0 * M_PI) * kSigma, 1e-3);
}

TEST(TimeLikelihood, finer_grids_do_not_forget_what_a_coarser_one_saw_elsewhere) {
  // Two times half a second apart; the second is 0.7 nats less likely.
  const auto two = [](double t) {
    const auto about = [&](double mean) { return std::exp(-0.5 * std::pow((t - mean) / 0.05, 2)); };
    return std::log(about(30.0) + std::exp(-0.7) * about(30.5) + 1e-300);
  };
  TimeLikelihood likelihood;
  likelihood.take(grid_about(30.0, 0.04, 25, two));
  const double before = likelihood.sigma_s(), width = likelihood.width_s();
  // Their mean square about the first.
  const double share = std::exp(-0.7) / (1.0 + std::exp(-0.7));
  EXPECT_NEAR(before, std::sqrt(share * 0.25 + 0.05 * 0.05), 0.02);
  likelihood.narrow(0.2);
  EXPECT_NEAR(likelihood.sigma_s(), before, 1e-12);  // nothing finer has been seen yet
  likelihood.take(grid_about(30.0, 0.01, 20, two));
  EXPECT_NEAR(likelihood.sigma_s(), before, 0.02);
  EXPECT_NEAR(likelihood.width_s(), width, 0.002);
}

TEST(TimeLikelihood, what_lies_elsewhere_counts_less_where_the_finer_grid_finds_better_times) {
  const auto flat = [](double t) { return -1e-12 * std::abs(t - 5.0); };
  TimeLikelihood likelihood;
  likelihood.take(grid_about(5.0, 0.1, 20, flat));
  EXPECT_NEAR(likelihood.width_s(), 4.1, 1e-9);
  likelihood.narrow(0.15);
  // One time that no coarse grid met is 10 nats better than all others.
  likelihood.take(
      grid_about(5.0, 0.01, 10, [](double t) { return std::abs(t - 5.05) < 1e-6 ? 10.0 : 0.0; }));
  EXPECT_NEAR(likelihood.width_s(), 0.01 + std::exp(-10.0) * (0.2 + 3.8), 1e-6);
  EXPECT_LT(likelihood.sigma_s(), 0.2);
}

}  // namespace
}  // namespace magimu
