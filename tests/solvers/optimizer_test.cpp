// SPDX-License-Identifier: BSD-3-Clause
// Gauss-Newton and Levenberg-Marquardt find the minimum, whatever the back end.
#include <Eigen/QR>

#include "solvers/levenberg_marquardt.h"
#include "tests/solvers/example_graphs.h"
#include "tests/solvers/scalar_factors.h"

namespace magimu {
namespace {

using test::Problem;
using test::residual;
using test::scalars;
using test::x_key;

OptimizerOptions with(Backend backend) {
  OptimizerOptions options;
  options.backend = backend;
  return options;
}

// Gauss-Newton by dense QR, sharing nothing with the solvers but the linearization.
Values dense_minimizer(const FactorGraph& graph, Values values) {
  for (int i = 0; i < 30; ++i) {
    LinearSystem system(graph, values);
    system.linearize(values);
    const MatrixXd J = test::dense_jacobian(system);
    const VectorXd scale = J.colwise().norm().cwiseInverse().transpose();
    const MatrixXd JS = J * scale.asDiagonal();
    const VectorXd y = JS.colPivHouseholderQr().solve(-system.residual());
    values = test::moved(values, scale.cwiseProduct(y));
    if ((JS * y).norm() < 1e-10) break;
  }
  return values;
}

void expect_every_solver_finds_the_dense_minimum(const Problem& p) {
  const Values expected = dense_minimizer(p.graph, p.start);
  const double cost = p.graph.cost(expected);
  for (const Backend backend : test::backends()) {
    const Result gn = GaussNewton(p.graph, with(backend)).optimize(p.start);
    const Result lm = LevenbergMarquardt(p.graph, with(backend)).optimize(p.start);
    for (const Result& result : {gn, lm}) {
      SCOPED_TRACE(to_string(backend) + (&result == &gn ? " GN: " : " LM: ") + result.message);
      EXPECT_TRUE(result.converged());
      EXPECT_NEAR(result.cost_final, cost, 1e-8 * cost);
      EXPECT_LT(test::sigmas_between(p.graph, expected, result.values), 1e-6);
      EXPECT_NEAR(p.graph.cost(result.values), result.cost_final, 1e-12 * cost);
    }
  }
}

TEST(Optimizers, agree_with_dense_algebra_on_a_chain_with_globals) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Problem p = test::chain_with_globals(seed, 60);
    expect_every_solver_finds_the_dense_minimum(p);
  }
}

TEST(Optimizers, agree_with_dense_algebra_on_a_pose_graph_with_loops) {
  for (const unsigned seed : {4U, 5U, 6U}) {
    const Problem p = test::pose_graph(seed, 60);
    expect_every_solver_finds_the_dense_minimum(p);
  }
}

// Twice the cost at the minimum is chi-square with rows - columns degrees of freedom.
TEST(Optimizers, leave_a_cost_that_the_noise_explains) {
  for (const Problem& p : {test::chain_with_globals(7, 300), test::pose_graph(8, 300)}) {
    const Result result = LevenbergMarquardt(p.graph).optimize(p.start);
    const LinearSystem system(p.graph, p.start);
    const double dof = system.rows() - system.cols();
    EXPECT_NEAR(2.0 * result.cost_final, dof, 5.0 * std::sqrt(2.0 * dof));
  }
}

TEST(Optimizers, linear_problems_need_one_step) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return 3.0 * x + y - 5.0; }));
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return x - 2.0 * y + 3.0; }));
  graph.add(residual(x_key(0), [](auto x) { return x - 2.0; }));
  const Result result = GaussNewton(graph).optimize(scalars({100.0, -300.0}));
  EXPECT_TRUE(result.converged());
  EXPECT_LE(result.iterations, 2);
}

// NIST StRD BoxBOD: y = a (1 - exp(-b x)). Its second start is near enough for both; from (50, 1)
// full steps leave the plateau for good.
TEST(LevenbergMarquardt, solves_boxbod_from_a_start_where_gauss_newton_fails) {
  FactorGraph graph;
  const double data[6][2] = {{1, 109}, {2, 149}, {3, 149}, {5, 191}, {7, 213}, {10, 224}};
  for (const auto& row : data) {
    const double at = row[0], y = row[1];
    graph.add(residual(x_key(0), x_key(1), [at, y](const auto& a, const auto& b) {
      using std::exp;
      return y - a * (1.0 - exp(-b * at));
    }));
  }
  const Values near = scalars({100.0, 0.75}), far = scalars({50.0, 1.0});
  for (const Backend backend : test::backends()) {
    const GaussNewton gn(graph, with(backend));
    const LevenbergMarquardt lm(graph, with(backend));
    EXPECT_FALSE(gn.optimize(far).converged());
    for (const Result& result : {gn.optimize(near), lm.optimize(near), lm.optimize(far)}) {
      EXPECT_TRUE(result.converged()) << result.message;
      EXPECT_NEAR(2.0 * result.cost_final, 1.1680088766e+03, 1e-6);  // certified by NIST
      EXPECT_NEAR(result.values.at<double>(x_key(0)), 2.1380940889e+02, 1e-4);
      EXPECT_NEAR(result.values.at<double>(x_key(1)), 5.4723748542e-01, 1e-6);
    }
  }
}

TEST(LevenbergMarquardt, follows_rosenbrocks_valley) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return 10.0 * (y - x * x); }));
  graph.add(residual(x_key(0), [](auto x) { return 1.0 - x; }));
  const Result result = LevenbergMarquardt(graph).optimize(scalars({-1.2, 1.0}));
  EXPECT_TRUE(result.converged()) << result.message;
  EXPECT_NEAR(result.values.at<double>(x_key(0)), 1.0, 1e-6);
  EXPECT_NEAR(result.values.at<double>(x_key(1)), 1.0, 1e-6);
}

// Powell's function: at its minimum, zero, the Jacobian has half its rank.
TEST(LevenbergMarquardt, solves_powells_singular_function) {
  FactorGraph graph;
  const double root5 = std::sqrt(5.0), root10 = std::sqrt(10.0);
  graph.add(residual(x_key(0), x_key(1), [](auto a, auto b) { return a + 10.0 * b; }));
  graph.add(residual(x_key(2), x_key(3), [root5](auto c, auto d) { return root5 * (c - d); }));
  graph.add(
      residual(x_key(1), x_key(2), [](auto b, auto c) { return (b - 2.0 * c) * (b - 2.0 * c); }));
  graph.add(residual(x_key(0), x_key(3),
                     [root10](auto a, auto d) { return root10 * (a - d) * (a - d); }));
  const Result result = LevenbergMarquardt(graph).optimize(scalars({3.0, -1.0, 0.0, 1.0}));
  EXPECT_TRUE(result.converged()) << result.message;
  EXPECT_LT(result.cost_final, 1e-11);
}

TEST(LevenbergMarquardt, turns_poses_by_more_than_a_right_angle) {
  const Problem p = test::pose_graph(9, 20);
  test::RandomValue random(10);
  const Values far = test::moved(p.truth, test::random_delta(random, p.truth.dim(), 0.6));
  const Result near = LevenbergMarquardt(p.graph).optimize(p.truth);
  const Result result = LevenbergMarquardt(p.graph).optimize(far);
  EXPECT_TRUE(result.converged()) << result.message;
  EXPECT_NEAR(result.cost_final, near.cost_final, 1e-8 * near.cost_final);
}

// Data without noise: at the truth, all that is left of the residuals is rounding.
TEST(Optimizers, converge_on_perfect_data_even_when_started_at_the_solution) {
  for (int n = 5; n < 25; ++n) {
    Problem p = test::pose_graph(11, n);
    FactorGraph perfect;
    for (const RelativeRotationFactor& f : p.graph.factors<RelativeRotationFactor>()) {
      const Rot3 iRj = p.truth.at<Rot3>(f.keys()[0]).inverse() * p.truth.at<Rot3>(f.keys()[1]);
      perfect.add(RelativeRotationFactor(f.keys()[0], f.keys()[1], iRj, Noise<3>::isotropic(1e-4)));
    }
    perfect.add(PriorFactor<Rot3>(R(0), p.truth.at<Rot3>(R(0)), Noise<3>::isotropic(1e-4)));
    for (const Values& start : {p.truth, p.start}) {
      const Result lm = LevenbergMarquardt(perfect).optimize(start);
      EXPECT_TRUE(lm.converged()) << n << ": " << lm.message;
      EXPECT_LT(lm.cost_final, 1e-18);
      const Result gn = GaussNewton(perfect).optimize(start);
      EXPECT_TRUE(gn.converged()) << n << ": " << gn.message;
    }
  }
}

}  // namespace
}  // namespace magimu
