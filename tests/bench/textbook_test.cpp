// SPDX-License-Identifier: BSD-3-Clause
// What the library's speed is measured against must solve the library's problem.
#include "bench/engine/textbook.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "bench/engine/engine_problem.h"
#include "bench/engine/forked.h"
#include "solvers/levenberg_marquardt.h"

namespace magimu {
namespace {

EngineProblem short_problem() {
  EngineCase c;
  c.simulated.motion = SimulatedMotion::kHand;
  c.simulated.rate_hz = 10.0;
  return make_problem(c);
}

TEST(Textbook, starts_from_the_same_values_as_the_library) {
  const EngineProblem problem = short_problem();
  const Values start = to_values(problem.start, problem.textbook_start);
  EXPECT_DOUBLE_EQ(problem.graph.cost(start), problem.graph.cost(problem.start));
}

TEST(Textbook, ends_where_the_library_does) {
  const EngineProblem problem = short_problem();
  Textbook textbook(*problem.textbook_data, problem.textbook_start);
  double step = 1.0;
  for (int i = 0; i < 8 && step > 1e-6; ++i) step = textbook.iterate();
  EXPECT_LT(step, 1e-6);
  const Result library = LevenbergMarquardt(problem.graph).optimize(problem.start);
  ASSERT_TRUE(library.converged()) << library.message;
  const Values ours = to_values(problem.start, textbook.unknowns());
  EXPECT_NEAR(problem.graph.cost(ours) / library.cost_final, 1.0, 1e-9);
  EXPECT_LT(library.values.local_coordinates(ours).norm(), 1e-6);
}

TEST(MeasureInChild, tells_of_cost_memory_and_failures) {
  const EngineProblem problem = short_problem();
  const auto cost = [&](const Values& values) { return problem.graph.cost(values); };
  const Measured good = measure_in_child([&] { return Solved{problem.start, 3, true}; }, cost, 60);
  EXPECT_EQ(good.failure, "");
  EXPECT_EQ(good.iterations, 3);
  EXPECT_TRUE(good.converged);
  EXPECT_EQ(good.cost, problem.graph.cost(problem.start));
  const auto throws = []() -> Solved { throw std::runtime_error("out of luck"); };
  EXPECT_EQ(measure_in_child(throws, cost, 60).failure, "out of luck");
  const auto never = []() -> Solved {
    while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
  };
  EXPECT_EQ(measure_in_child(never, cost, 1).failure, "more than 1 s");
}

}  // namespace
}  // namespace magimu
