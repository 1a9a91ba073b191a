// SPDX-License-Identifier: BSD-3-Clause
// Results have the same bits for every number of threads.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "solvers/levenberg_marquardt.h"
#include "solvers/marginals.h"
#include "tests/solvers/example_graphs.h"

namespace magimu {
namespace {

template <class Body>
auto with_threads(int threads, const Body& body) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  std::size_t(threads));
  tbb::task_arena arena(threads);
  return arena.execute(body);
}

std::vector<double> bits(const Values& v) { return {v.data().begin(), v.data().end()}; }

TEST(Threads, optimizers_and_marginals_give_the_same_bits) {
  const test::Problem p = test::chain_with_globals(1, 560);  // more than one task a kind of factor
  for (const Backend backend : test::backends()) {
    OptimizerOptions options;
    options.backend = backend;
    const auto lm = [&] { return LevenbergMarquardt(p.graph, options).optimize(p.start); };
    const auto gn = [&] { return GaussNewton(p.graph, options).optimize(p.start); };
    const Result one = with_threads(1, lm), two = with_threads(2, lm);
    ASSERT_TRUE(one.converged());
    EXPECT_EQ(bits(one.values), bits(two.values)) << to_string(backend);
    EXPECT_EQ(one.cost_final, two.cost_final) << to_string(backend);
    EXPECT_EQ(one.iterations, two.iterations) << to_string(backend);
    EXPECT_EQ(bits(with_threads(1, gn).values), bits(with_threads(2, gn).values))
        << to_string(backend);
    const auto covariance = [&] {
      return Marginals(p.graph, one.values, backend).covariance(key::distortion);
    };
    EXPECT_EQ(with_threads(1, covariance), with_threads(2, covariance)) << to_string(backend);
  }
}

}  // namespace
}  // namespace magimu
