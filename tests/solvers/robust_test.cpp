// SPDX-License-Identifier: BSD-3-Clause
// Robust losses and outliers: a line y = a + b t of which 30 % of the points are wrong.
#include "solvers/levenberg_marquardt.h"
#include "tests/factors/jacobian_check.h"
#include "tests/solvers/scalar_factors.h"

namespace magimu {
namespace {

using test::residual;
using test::scalars;
using test::x_key;

constexpr double kA = 2.0, kB = -0.7, kSigma = 0.1;
constexpr int kPoints = 200;

FactorGraph line(unsigned seed, Loss loss, bool outliers = true) {
  test::RandomValue random(seed);
  FactorGraph graph;
  for (int i = 0; i < kPoints; ++i) {
    const double t = 10.0 * i / kPoints;
    double y = kA + kB * t + random.number(kSigma);
    const double wrong = 3.0 + std::abs(random.number(3.0));  // always upwards: no luck averages it
    if (outliers && i % 10 < 3) y += wrong;
    graph.add(residual(
        x_key(0), x_key(1), [t, y](auto a, auto b) { return y - a - b * t; },
        Noise<1>::isotropic(kSigma).with_loss(loss)));
  }
  return graph;
}

double error(const Result& result) {
  return std::hypot(result.values.at<double>(x_key(0)) - kA,
                    5.0 * (result.values.at<double>(x_key(1)) - kB));
}

TEST(Robust, losses_recover_a_line_from_30_percent_outliers) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const FactorGraph plain_graph = line(seed, {});
    const Result plain = LevenbergMarquardt(plain_graph).optimize(scalars({0.0, 0.0}));
    EXPECT_GT(error(plain), 1.0);
    const FactorGraph huber_graph = line(seed, Loss::huber());
    const Result huber = LevenbergMarquardt(huber_graph).optimize(scalars({0.0, 0.0}));
    EXPECT_TRUE(huber.converged()) << huber.message;
    EXPECT_LT(error(huber), 0.15);  // outliers keep a bounded pull
    const FactorGraph cauchy_graph = line(seed, Loss::cauchy());
    const Result cauchy = LevenbergMarquardt(cauchy_graph).optimize(huber.values);
    EXPECT_TRUE(cauchy.converged()) << cauchy.message;
    EXPECT_LT(error(cauchy), 0.06);
    const FactorGraph tukey_graph = line(seed, Loss::tukey());
    const Result tukey = LevenbergMarquardt(tukey_graph).optimize(huber.values);
    EXPECT_TRUE(tukey.converged()) << tukey.message;
    EXPECT_LT(error(tukey), 0.06);  // outliers have no pull at all
  }
}

TEST(Robust, tukey_takes_the_outliers_out_and_nothing_else) {
  const FactorGraph tukey_graph = line(5, Loss::tukey(6.0));
  const Result tukey = LevenbergMarquardt(tukey_graph).optimize(scalars({kA, kB}));
  LinearSystem system(tukey_graph, tukey.values);
  system.linearize(tukey.values);
  for (int i = 0; i < kPoints; ++i) {
    const bool outlier = i % 10 < 3;
    EXPECT_EQ(system.residual()[i] == 0.0, outlier) << i;
  }
}

TEST(Robust, losses_change_little_where_there_are_no_outliers) {
  const FactorGraph plain_graph = line(6, {}, false);
  const Result plain = LevenbergMarquardt(plain_graph).optimize(scalars({0.0, 0.0}));
  for (const Loss& loss : {Loss::huber(), Loss::cauchy(), Loss::tukey()}) {
    const FactorGraph graph = line(6, loss, false);
    const Result robust = LevenbergMarquardt(graph).optimize(plain.values);
    EXPECT_TRUE(robust.converged()) << robust.message;
    EXPECT_LT(std::abs(error(robust) - error(plain)), 0.02);
  }
}

// Where every weight is zero nothing draws the estimate anywhere: that is no optimum.
TEST(Robust, losses_that_leave_every_factor_out_are_not_called_converged) {
  FactorGraph graph;
  for (const double z : {100.0, 101.0, 99.0}) {
    graph.add(residual(
        x_key(0), [z](auto x) { return x - z; },
        Noise<1>::isotropic(1.0).with_loss(Loss::tukey())));
  }
  const Result far = LevenbergMarquardt(graph).optimize(scalars({0.0}));
  EXPECT_EQ(far.reason, StopReason::kSingular);
  EXPECT_NE(far.message.find("weight 0"), std::string::npos) << far.message;
  const Result near = LevenbergMarquardt(graph).optimize(scalars({98.0}));
  EXPECT_TRUE(near.converged()) << near.message;
  EXPECT_NEAR(near.values.at<double>(x_key(0)), 100.0, 1e-3);
}

}  // namespace
}  // namespace magimu
