// SPDX-License-Identifier: BSD-3-Clause
// Numbers that are not finite end with the factor's name, never in a loop.
#include <limits>

#include "graph/numerical_error.h"
#include "solvers/back_ends.h"
#include "solvers/damped_factor.h"
#include "solvers/marginals.h"
#include "tests/solvers/each_backend.h"

namespace magimu {
namespace {

const auto log_of = [](auto x) {
  using std::log;
  return log(x);
};

// Two variables, of which the second has a residual that is not finite at zero.
FactorGraph two_logarithms() {
  FactorGraph graph;
  graph.add(residual(x_key(0), log_of));
  graph.add(residual(x_key(1), log_of));
  return graph;
}

class NotFiniteIn : public test::EachBackend {};
MAGIMU_TEST_EACH_BACKEND(NotFiniteIn);

TEST_P(NotFiniteIn, a_damped_factorization_names_the_factor_instead_of_trying_for_ever) {
  const FactorGraph graph = two_logarithms();
  const Values at = scalars({1.0, 0.0});
  LinearSystem system(graph, at);
  system.linearize(at);
  const auto solver = make_linear_solver(GetParam());
  const VectorXd scale = column_scale(system);
  EXPECT_THAT([&] { factorize_damped(*solver, system, scale, graph, at); },
              ThrowsMessage<NumericalError>(HasSubstr("the factor on (x1)")));
  EXPECT_THROW(factorize_damped(*solver, system, scale), NumericalError);
  EXPECT_THROW((void)find_null_space(system, *solver), NumericalError);
}

TEST_P(NotFiniteIn, marginals_refuse_it) {
  const FactorGraph graph = two_logarithms();
  EXPECT_THROW(Marginals(graph, scalars({1.0, 0.0}), GetParam()), NumericalError);
}

// As noise of 1e-20 makes them.
TEST_P(NotFiniteIn, numbers_too_large_for_squares_end_too) {
  FactorGraph graph;
  graph.add(residual(x_key(0), log_of, Noise<1>::isotropic(1e-200)));
  graph.add(residual(x_key(0), x_key(1), [](auto a, auto b) { return a - b; }));
  const Values at = scalars({2.0, 1.0});
  LinearSystem system(graph, at);
  system.linearize(at);
  const auto solver = make_linear_solver(GetParam());
  EXPECT_THROW(factorize_damped(*solver, system, column_scale(system), graph, at), NumericalError);
}

TEST_P(NotFiniteIn, a_direction_left_free_takes_little_damping) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto a, auto b) { return a - b; }));
  const Values at = scalars({2.0, 1.0});
  LinearSystem system(graph, at);
  system.linearize(at);
  const auto solver = make_linear_solver(GetParam());
  EXPECT_LT(factorize_damped(*solver, system, column_scale(system)), 1e-8);
}

TEST_P(NotFiniteIn, optimizers_name_the_factor) {
  const FactorGraph graph = two_logarithms();
  OptimizerOptions options;
  options.backend = GetParam();
  for (const Result& result : {LevenbergMarquardt(graph, options).optimize(scalars({1.0, 0.0})),
                               GaussNewton(graph, options).optimize(scalars({1.0, 0.0}))}) {
    EXPECT_EQ(result.reason, StopReason::kNotFinite);
    EXPECT_THAT(result.message, HasSubstr("the residual of the factor on (x1)"));
  }
}

TEST(NotFiniteInWindows, optimizers_name_the_variable) {
  test::Problem p = test::chain_with_globals(11, 100);
  p.start.update(key::dip, std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(LevenbergMarquardt(p.graph).optimize(p.start).message,
              HasSubstr("variable " + to_string(key::dip)));
}

}  // namespace
}  // namespace magimu
