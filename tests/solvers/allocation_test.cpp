// SPDX-License-Identifier: BSD-3-Clause
// Nothing is allocated for a factor in an iteration of the windows: a pass over a graph with many
// more factors in as many windows asks for memory as often. Not under the sanitizers, which have an
// operator new of their own.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "solvers/lanes/window_engine.h"
#include "tests/solvers/example_graphs.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MAGIMU_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MAGIMU_SANITIZED
#endif
#endif

#ifndef MAGIMU_SANITIZED

namespace {

std::atomic<long> allocations{0};

}  // namespace

// The program's own, counted.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace magimu {
namespace {

long allocations_of_an_iteration(int nodes, EliminationForm form) {
  const test::Problem p = test::chain_with_globals(1, nodes);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto engine = WindowEngine::make(p.graph, p.start, best_isa(), form);
  engine->load(p.start);
  engine->condense(1e-4);
  EXPECT_TRUE(engine->solve());
  engine->advance(1e-4);
  engine->keep_candidate();
  const long before = allocations;
  EXPECT_TRUE(engine->solve());
  engine->advance(1e-4);
  return allocations - before;
}

TEST(Allocations, none_for_a_factor_in_an_iteration) {
  for (const EliminationForm form : {EliminationForm::kInformation, EliminationForm::kSquareRoot}) {
    const long few = allocations_of_an_iteration(700, form);
    const long many = allocations_of_an_iteration(1400, form);
    EXPECT_GT(few, 0);  // they are counted
    EXPECT_LT(few, 200) << to_string(form);
    EXPECT_NEAR(double(many), double(few), 20.0) << to_string(form);  // of 2,100 more factors
  }
}

}  // namespace
}  // namespace magimu

#endif  // MAGIMU_SANITIZED
