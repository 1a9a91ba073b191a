// SPDX-License-Identifier: BSD-3-Clause
// Every way in which an optimization can end, and what it says then; and its trace.
#include "tests/solvers/each_backend.h"

namespace magimu {
namespace {

class StopReasons : public test::EachBackend {};
MAGIMU_TEST_EACH_BACKEND(StopReasons);

const auto log_of = [](const auto& x) {
  using std::log;
  return log(x);
};
const auto atan_of = [](const auto& x) {
  using std::atan;
  return atan(x);
};
// Finite at 0, but its derivative is not.
const auto root_of = [](const auto& x) {
  using std::sqrt;
  return sqrt(x) - 1.0;
};

// x^2 - 1 with the derivative's sign wrong.
class WrongJacobian : public Factor<1, double> {
 public:
  explicit WrongJacobian(Key x) : Factor({x}, {}) {}
  template <class T>
  Vec<T, 1> residual(const T& x) const {
    return Vec<T, 1>(x * x - T(1.0));
  }
  template <class T>
  Vec<T, 1> linearize(const T& x, Vec<T, 1>& J) const {
    J[0] = -2.0 * x;
    return residual(x);
  }
};

TEST_P(StopReasons, converged_says_how_small_the_last_step_was) {
  const Problem p = test::pose_graph(1, 20);
  for (const Result& result : {LevenbergMarquardt(p.graph, options()).optimize(p.start),
                               GaussNewton(p.graph, options()).optimize(p.start)}) {
    EXPECT_EQ(result.reason, StopReason::kConverged);
    EXPECT_TRUE(result.converged());
    EXPECT_THAT(result.message, HasSubstr("standard deviations"));
    EXPECT_LT(result.trace.back().step_sigma, 1e-6);
    EXPECT_LT(result.gradient_norm, 1e-5);
    EXPECT_GT(result.seconds, 0.0);
  }
}

TEST_P(StopReasons, max_iterations_says_that_this_is_not_the_optimum) {
  const Problem p = test::pose_graph(2, 20);
  for (const int limit : {0, 1, 2}) {
    OptimizerOptions o = options();
    o.max_iterations = limit;
    for (const Result& result : {LevenbergMarquardt(p.graph, o).optimize(p.start),
                                 GaussNewton(p.graph, o).optimize(p.start)}) {
      EXPECT_EQ(result.reason, StopReason::kMaxIterations);
      EXPECT_FALSE(result.converged());
      EXPECT_EQ(result.iterations, limit);
      EXPECT_THAT(result.message, HasSubstr("limit of " + std::to_string(limit)));
      EXPECT_THAT(result.message, HasSubstr("not the optimum"));
    }
  }
}

TEST_P(StopReasons, no_decrease_suspects_the_jacobian) {
  FactorGraph graph;
  graph.add(WrongJacobian(x_key(0)));
  const Result result = LevenbergMarquardt(graph, options()).optimize(scalars({2.0}));
  EXPECT_EQ(result.reason, StopReason::kNoDecrease);
  EXPECT_THAT(result.message, HasSubstr("Jacobian is wrong"));
  EXPECT_EQ(result.values.at<double>(x_key(0)), 2.0);
  EXPECT_EQ(result.cost_final, result.cost_initial);
  for (const IterationRecord& record : result.trace) EXPECT_FALSE(record.accepted);
}

TEST_P(StopReasons, singular_says_what_to_add) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return x + y - 1.0; }));
  const Result result = GaussNewton(graph, options()).optimize(scalars({2.0, 3.0}));
  EXPECT_EQ(result.reason, StopReason::kSingular);
  EXPECT_THAT(result.message, HasSubstr("x0"));
  EXPECT_THAT(result.message, HasSubstr("x1"));
  EXPECT_THAT(result.message, HasSubstr("Add a factor"));
}

TEST_P(StopReasons, residuals_that_are_not_finite_at_the_start_are_found) {
  FactorGraph graph;
  graph.add(residual(x_key(0), log_of));
  for (const double x : {0.0, -1.0, std::nan("")}) {
    for (const Result& result : {LevenbergMarquardt(graph, options()).optimize(scalars({x})),
                                 GaussNewton(graph, options()).optimize(scalars({x}))}) {
      EXPECT_EQ(result.reason, StopReason::kNotFinite);
      EXPECT_THAT(result.message, HasSubstr("initial values"));
      EXPECT_EQ(result.iterations, 0);
    }
  }
}

TEST_P(StopReasons, a_jacobian_that_is_not_finite_is_found) {
  FactorGraph graph;
  graph.add(residual(x_key(0), root_of));
  graph.add(residual(x_key(1), [](auto x) { return x - 1.0; }));
  const Values start = scalars({0.0, 0.0});
  for (const Result& result : {LevenbergMarquardt(graph, options()).optimize(start),
                               GaussNewton(graph, options()).optimize(start)}) {
    EXPECT_EQ(result.reason, StopReason::kNotFinite) << result.message;
    EXPECT_THAT(result.message, HasSubstr("Jacobian"));
    EXPECT_EQ(result.values.at<double>(x_key(0)), 0.0);
  }
}

// From 10 the full step on log x leads to a negative x.
TEST_P(StopReasons, a_full_step_out_of_the_domain_is_shortened_by_levenberg_marquardt_only) {
  FactorGraph graph;
  graph.add(residual(x_key(0), log_of));
  const Result gn = GaussNewton(graph, options()).optimize(scalars({10.0}));
  EXPECT_EQ(gn.reason, StopReason::kNotFinite);
  EXPECT_THAT(gn.message, HasSubstr("Levenberg-Marquardt would have shortened it"));
  const Result lm = LevenbergMarquardt(graph, options()).optimize(scalars({10.0}));
  EXPECT_TRUE(lm.converged()) << lm.message;
  EXPECT_NEAR(lm.values.at<double>(x_key(0)), 1.0, 1e-6);
}

// Full steps on atan x overshoot further and further from |x| > 1.39 on.
TEST_P(StopReasons, rising_costs_stop_gauss_newton) {
  FactorGraph graph;
  graph.add(residual(x_key(0), atan_of));
  const Result gn = GaussNewton(graph, options()).optimize(scalars({1.5}));
  EXPECT_EQ(gn.reason, StopReason::kDiverged);
  EXPECT_THAT(gn.message, HasSubstr("Levenberg-Marquardt"));
  const Result lm = LevenbergMarquardt(graph, options()).optimize(scalars({1.5}));
  EXPECT_TRUE(lm.converged()) << lm.message;
  EXPECT_NEAR(lm.values.at<double>(x_key(0)), 0.0, 1e-6);
}

TEST(StopReason, has_a_name) {
  EXPECT_EQ(to_string(StopReason::kConverged), "converged");
  EXPECT_EQ(to_string(StopReason::kMaxIterations), "max_iterations");
  EXPECT_EQ(to_string(StopReason::kNoDecrease), "no_decrease");
  EXPECT_EQ(to_string(StopReason::kSingular), "singular");
  EXPECT_EQ(to_string(StopReason::kNotFinite), "not_finite");
  EXPECT_EQ(to_string(StopReason::kDiverged), "diverged");
}

TEST_P(StopReasons, the_trace_of_levenberg_marquardt_tells_a_consistent_story) {
  FactorGraph valley;  // Rosenbrock's: steps of all kinds
  valley.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return 10.0 * (y - x * x); }));
  valley.add(residual(x_key(0), [](auto x) { return 1.0 - x; }));
  const Values start = scalars({-1.2, 1.0});
  const Result result = LevenbergMarquardt(valley, options()).optimize(start);
  ASSERT_EQ(int(result.trace.size()), result.iterations);
  EXPECT_EQ(result.cost_initial, valley.cost(start));
  EXPECT_EQ(result.trace.back().cost, result.cost_final);
  EXPECT_EQ(result.trace.back().step_norm, result.step_norm);
  double cost = result.cost_initial;
  int rejected = 0;
  for (const IterationRecord& record : result.trace) {
    EXPECT_EQ(record.iteration, int(&record - result.trace.data()));
    EXPECT_GE(record.damping, 0.0);
    EXPECT_GE(record.step_norm, 0.0);
    if (record.accepted) {
      EXPECT_LT(record.cost, cost);
      EXPECT_GT(record.gain_ratio, OptimizerOptions{}.min_gain_ratio);
    } else {
      EXPECT_EQ(record.cost, cost);
      EXPECT_LE(record.gain_ratio, OptimizerOptions{}.min_gain_ratio);
      ++rejected;
    }
    cost = record.cost;
  }
  EXPECT_GT(rejected, 0);
  EXPECT_LT(result.trace.back().gradient_norm, result.trace.front().gradient_norm);
}

// On a linear problem the model is exact: a full step gains what it promises, and its length in
// standard deviations is the root of twice the decrease.
TEST_P(StopReasons, a_linear_problem_has_gain_ratio_one) {
  FactorGraph graph;
  const Noise<1> noise = Noise<1>::isotropic(0.1);
  graph.add(residual(
      x_key(0), x_key(1), [](auto x, auto y) { return x + y - 3.0; }, noise));
  graph.add(residual(
      x_key(0), x_key(1), [](auto x, auto y) { return x - y + 1.0; }, noise));
  const Result result = GaussNewton(graph, options()).optimize(scalars({5.0, -4.0}));
  const IterationRecord& first = result.trace.front();
  EXPECT_NEAR(first.gain_ratio, 1.0, 1e-12);
  EXPECT_NEAR(first.step_sigma, std::sqrt(2.0 * (result.cost_initial - first.cost)), 1e-9);
  EXPECT_NEAR(first.step_norm, std::hypot(4.0, 6.0), 1e-12);
  // before the step: |S J'r| with columns of norm sqrt(2) / 0.1, residuals -20 and 100
  EXPECT_NEAR(first.gradient_norm, std::hypot(80.0, -120.0) / std::sqrt(2.0), 1e-9);
}

}  // namespace
}  // namespace magimu
