// SPDX-License-Identifier: BSD-3-Clause
// Gauss-Newton and Levenberg-Marquardt find the minimum, whatever the back end.
#include <Eigen/QR>
#include <algorithm>

#include "tests/solvers/each_backend.h"

namespace magimu {
namespace {

using test::with;

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

// NIST StRD BoxBOD: y = a (1 - exp(-b x)). Its second start, (100, 0.75), is near enough for both
// optimizers; from (50, 1) full steps leave for the plateau where b is so large that it no longer
// matters; from NIST's first start, (1, 1), only short steps avoid it.
FactorGraph boxbod(double unit = 1.0) {
  FactorGraph graph;
  const double data[6][2] = {{1, 109}, {2, 149}, {3, 149}, {5, 191}, {7, 213}, {10, 224}};
  for (const auto& row : data) {
    const double at = row[0], y = row[1];
    graph.add(residual(x_key(0), x_key(1), [at, y, unit](const auto& a, const auto& b) {
      using std::exp;
      return (y - a * (1.0 - exp(-b * at))) * unit;
    }));
  }
  return graph;
}
void expect_boxbods_answer(const Result& result) {  // certified by NIST
  EXPECT_TRUE(result.converged()) << result.message;
  EXPECT_NEAR(2.0 * result.cost_final, 1.1680088766e+03, 1e-6);
  EXPECT_NEAR(result.values.at<double>(x_key(0)), 2.1380940889e+02, 1e-4);
  EXPECT_NEAR(result.values.at<double>(x_key(1)), 5.4723748542e-01, 1e-6);
}

TEST(LevenbergMarquardt, solves_boxbod_from_a_start_where_gauss_newton_fails) {
  const FactorGraph graph = boxbod();
  const Values near = scalars({100.0, 0.75}), far = scalars({50.0, 1.0});
  for (const Backend backend : test::backends()) {
    const GaussNewton gn(graph, with(backend));
    const LevenbergMarquardt lm(graph, with(backend));
    EXPECT_FALSE(gn.optimize(far).converged());
    for (const Result& result : {gn.optimize(near), lm.optimize(near), lm.optimize(far)}) {
      expect_boxbods_answer(result);
    }
  }
}

TEST(LevenbergMarquardt, with_short_first_steps_and_the_largest_norms_solves_it_from_far_away) {
  const FactorGraph graph = boxbod();
  for (const Backend backend : test::backends()) {
    OptimizerOptions options = with(backend);
    options.damp_by_largest_norm = true;
    options.initial_damping = 100.0;
    expect_boxbods_answer(LevenbergMarquardt(graph, options).optimize(scalars({1.0, 1.0})));
  }
}

TEST(LevenbergMarquardt, a_plateau_is_called_one_and_no_jacobian_is_blamed) {
  const FactorGraph graph = boxbod();
  for (const Backend backend : test::backends()) {
    for (const double damping : {1e-4, 1e-2, 1.0}) {
      OptimizerOptions options = with(backend);
      options.initial_damping = damping;
      const Result result = LevenbergMarquardt(graph, options).optimize(scalars({1.0, 1.0}));
      EXPECT_THAT(result.message, HasSubstr("plateau")) << to_string(backend);
      EXPECT_THAT(result.message, Not(HasSubstr("Jacobian")));
    }
  }
}

// One step of a heavily damped optimizer is as short as one likes, wherever it starts.
TEST(LevenbergMarquardt, a_large_initial_damping_is_not_taken_for_convergence) {
  FactorGraph graph;
  graph.add(residual(x_key(0), [](auto x) { return x - 1.0; }));
  OptimizerOptions options;
  options.initial_damping = 1e9;
  const Result result = LevenbergMarquardt(graph, options).optimize(scalars({2.0}));
  EXPECT_TRUE(result.converged()) << result.message;
  EXPECT_NEAR(result.values.at<double>(x_key(0)), 1.0, 1e-9);
}

// Without noise_from_residuals the first of these would stop early and the last hardly ever.
TEST(Optimizers, noise_from_residuals_makes_the_unit_of_the_residuals_irrelevant) {
  OptimizerOptions options;
  options.noise_from_residuals = true;
  const Values start = scalars({100.0, 0.75});
  const FactorGraph usual = boxbod();
  const Result expected = LevenbergMarquardt(usual, options).optimize(start);
  expect_boxbods_answer(expected);
  for (const double unit : {std::ldexp(1.0, -60), std::ldexp(1.0, 60)}) {  // no new rounding
    const FactorGraph graph = boxbod(unit);
    const Result result = LevenbergMarquardt(graph, options).optimize(start);
    EXPECT_EQ(result.iterations, expected.iterations);
    EXPECT_EQ(result.message, expected.message);
    EXPECT_TRUE(std::ranges::equal(result.values.data(), expected.values.data()));
  }
}

// Near 1e9 doubles are 1e-7 apart, which is 1e-4 standard deviations here: smaller steps there are
// none, and the cost is no smoother.
TEST(Optimizers, converge_where_rounding_of_the_variables_exceeds_the_tolerance) {
  FactorGraph graph;
  for (const double d : {0.3e-3, -1.1e-3, 2.4e-3, 0.7e-3, -0.9e-3}) {
    graph.add(residual(
        x_key(0), [d](auto x) { return x - 1e9 / 3.0 - d; }, Noise<1>::isotropic(1e-3)));
    graph.add(residual(
        x_key(0), [d](auto x) { return x * 1.1 - 1.1e9 / 3.0 + d; }, Noise<1>::isotropic(1e-3)));
  }
  for (const Backend backend : test::backends()) {
    for (const double start : {3e8, 3.34e8, 1.0}) {
      for (const Result& result :
           {LevenbergMarquardt(graph, with(backend)).optimize(scalars({start})),
            GaussNewton(graph, with(backend)).optimize(scalars({start}))}) {
        EXPECT_TRUE(result.converged()) << result.message;
        EXPECT_LE(result.iterations, 20);
        EXPECT_NEAR(result.values.at<double>(x_key(0)), 1e9 / 3.0, 1e-3);
      }
    }
  }
}

// The full step leaves the valley's floor and rises; the one after it is at the minimum.
TEST(LevenbergMarquardt, follows_rosenbrocks_valley_by_steps_that_rise_and_come_down) {
  for (const double steepness : {10.0, 1e4}) {
    FactorGraph graph;
    graph.add(residual(x_key(0), x_key(1),
                       [steepness](auto x, auto y) { return steepness * (y - x * x); }));
    graph.add(residual(x_key(0), [](auto x) { return 1.0 - x; }));
    for (const Backend backend : test::backends()) {
      OptimizerOptions options = with(backend);
      options.initial_damping = 0.0;
      const Result creeping = LevenbergMarquardt(graph, options).optimize(scalars({-1.2, 1.0}));
      options.may_rise = true;
      const Result result = LevenbergMarquardt(graph, options).optimize(scalars({-1.2, 1.0}));
      EXPECT_LE(result.iterations, 4) << to_string(backend);
      EXPECT_GT(creeping.iterations, 10) << to_string(backend);
      for (const Result& found : {creeping, result}) {
        EXPECT_TRUE(found.converged()) << found.message;
        EXPECT_NEAR(found.values.at<double>(x_key(0)), 1.0, 1e-6);
        EXPECT_NEAR(found.values.at<double>(x_key(1)), 1.0, 1e-6);
      }
    }
  }
}

// From beyond 1.39 each full step is further away than the one before it: what rose is taken back.
TEST(LevenbergMarquardt, comes_back_where_steps_only_rise) {
  FactorGraph graph;
  graph.add(residual(x_key(0), [](auto x) {
    using std::atan;
    return atan(x);
  }));
  graph.add(residual(x_key(1), [](auto x) { return x - 3.0; }));
  for (const Backend backend : test::backends()) {
    for (const double start : {1.5, 2.0, 5.0, 30.0}) {
      OptimizerOptions options = with(backend);
      options.may_rise = true;
      const Result result = LevenbergMarquardt(graph, options).optimize(scalars({start, 0.0}));
      EXPECT_TRUE(result.converged()) << result.message;
      EXPECT_NEAR(result.values.at<double>(x_key(0)), 0.0, 1e-6);
      EXPECT_NEAR(result.values.at<double>(x_key(1)), 3.0, 1e-6);
    }
  }
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

TEST(OptimizerOptions, what_means_nothing_is_refused_by_name) {
  FactorGraph graph;
  graph.add(test::residual(test::x_key(0), [](auto x) { return x - 1.0; }));
  const Values start = test::scalars({0.0});
  const auto refused = [&](auto change, const std::string& name) {
    OptimizerOptions options;
    change(options);
    try {
      LevenbergMarquardt(graph, options).optimize(start);
      ADD_FAILURE() << name << " was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  const double nan = std::nan("");
  for (const double x : {-1.0, nan}) {
    refused([x](OptimizerOptions& o) { o.step_tolerance = x; }, "step_tolerance");
    refused([x](OptimizerOptions& o) { o.initial_damping = x; }, "initial_damping");
    refused([x](OptimizerOptions& o) { o.max_damping = x; }, "max_damping");
    refused([x](OptimizerOptions& o) { o.min_gain_ratio = x; }, "min_gain_ratio");
  }
  refused([](OptimizerOptions& o) { o.max_iterations = -5; }, "max_iterations");
}

TEST(Result, says_which_solver_was_chosen) {
  FactorGraph graph;
  graph.add(test::residual(test::x_key(0), [](auto x) { return x - 1.0; }));
  const Result result = LevenbergMarquardt(graph).optimize(test::scalars({0.0}));
  EXPECT_NE(result.solver, "auto");
  EXPECT_FALSE(result.solver.empty());
}

}  // namespace
}  // namespace magimu
