// SPDX-License-Identifier: BSD-3-Clause
// The covariance that does not believe the residuals to be white.
#include "solvers/sandwich.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "graph/factor_graph.h"
#include "solvers/levenberg_marquardt.h"
#include "solvers/marginals.h"

namespace magimu {
namespace {

constexpr Key kLine{'x', 0};

// y = a + b t of unit noise.
class PointFactor : public Factor<1, Vector2> {
 public:
  PointFactor(double t, double y) : Factor({kLine}, Noise<1>::isotropic(1.0)), t_(t), y_(y) {}
  template <class T>
  Vec<T, 1> residual(const Vec<T, 2>& line) const {
    return Vec<T, 1>(line[0] + line[1] * t_ - y_);
  }

 private:
  double t_, y_;
};

struct Fit {
  Vector2 estimate;
  MatrixXd model, robust;
};

// A line through n points whose noise is white, or the same over runs of points.
Fit fit_line(unsigned seed, int n, int run, int blocks) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  FactorGraph graph;
  double noise = 0.0;
  for (int i = 0; i < n; ++i) {
    if (i % run == 0) noise = normal(engine);
    const double t = 2.0 * i / n - 1.0;
    graph.add(PointFactor(t, 0.3 + 0.5 * t + noise));
  }
  Values values;
  values.insert(kLine, Vector2(0.0, 0.0));
  const Result result = LevenbergMarquardt(graph).optimize(values);
  LinearSystem system(graph, result.values);
  system.linearize(result.values);
  const MatrixXd H = Marginals(graph, result.values).covariance(kLine);
  std::vector<int> block;
  for (int i = 0; i < n; ++i) block.push_back(i * blocks / n);
  return {result.values.at<Vector2>(kLine), H, sandwich_covariance(system, H, H, block, blocks)};
}

// Mean of e' V^-1 e over many data sets, of 2 if V is what it says.
double mean_nees(int run, bool robust) {
  constexpr int kSets = 400;
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kSets; ++seed) {
    const Fit fit = fit_line(seed, 400, run, 20);
    const Vector2 e = fit.estimate - Vector2(0.3, 0.5);
    sum += e.dot((robust ? fit.robust : fit.model).llt().solve(e)) / kSets;
  }
  return sum;
}

// Unbiased but for what lies below the model and is raised to it: of a variance of 20 degrees of
// freedom, whose relative standard deviation is sqrt(2 / 20), that adds 0.4 of it.
TEST(Sandwich, white_noise_gives_the_model_covariance_and_little_more) {
  double ratio = 0.0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const Fit fit = fit_line(seed, 400, 1, 20);
    const VectorXd ratios = fit.robust.diagonal().cwiseQuotient(fit.model.diagonal());
    EXPECT_GE(ratios.minCoeff(), 1.0 - 1e-9);
    ratio += ratios.mean() / 100.0;
  }
  EXPECT_NEAR(ratio, 1.0 + 0.4 * std::sqrt(2.0 / 20.0), 0.08);
}

TEST(Sandwich, is_honest_where_noise_persists_and_the_model_is_not) {
  EXPECT_GT(mean_nees(5, false), 8.0);  // five times too confident in variance
  EXPECT_NEAR(mean_nees(5, true), 2.0, 0.5);
}

TEST(Sandwich, is_definite_however_few_the_blocks) {
  const Fit fit = fit_line(3, 400, 1, 2);
  EXPECT_EQ(fit.robust.llt().info(), Eigen::Success);
  EXPECT_GT(fit.robust.diagonal().minCoeff(), 0.0);
  const Fit one = fit_line(3, 400, 1, 1);  // no scatter at all: the model's
  EXPECT_EQ(one.robust, one.model);
}

TEST(Sandwich, a_direction_without_information_stays_singular_and_the_rest_is_unharmed) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  FactorGraph graph;
  for (int i = 0; i < 200; ++i) graph.add(PointFactor(1.0, normal(engine)));
  Values values;
  values.insert(kLine, Vector2(0.0, 0.0));
  LinearSystem system(graph, values);
  system.linearize(values);
  MatrixXd H(2, 2);  // the pseudo-inverse of J'J: only a + b is known
  H.setConstant(0.25 / 200.0);
  std::vector<int> block;
  for (int i = 0; i < 200; ++i) block.push_back(i / 10);
  const MatrixXd V = sandwich_covariance(system, H, H, block, 20);
  EXPECT_NEAR((V - V(0, 0) * MatrixXd::Ones(2, 2)).norm(), 0.0, 1e-12);
  EXPECT_GE(V(0, 0) / H(0, 0), 1.0 - 1e-9);
  EXPECT_LT(V(0, 0) / H(0, 0), 2.0);
}

}  // namespace
}  // namespace magimu
