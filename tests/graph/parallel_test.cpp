// SPDX-License-Identifier: BSD-3-Clause
// An exception in one body must leave all others as if it had not been thrown.
#include "graph/parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace magimu {
namespace {

constexpr int kOften = 200;

long filled_in_parallel(std::size_t n) {
  std::vector<long> out(n, 0);
  parallel::for_each(n, 8, [&](std::size_t i) { out[i] = 1; });
  return std::accumulate(out.begin(), out.end(), 0L);
}

TEST(Parallel, a_branch_that_throws_leaves_no_loop_of_another_undone) {
  for (int round = 0; round < kOften; ++round) {
    std::vector<long> sums;
    EXPECT_THROW(parallel::invoke([] { throw std::runtime_error("first"); },
                                  [&] {
                                    for (int i = 0; i < 20; ++i) {
                                      sums.push_back(filled_in_parallel(4000));
                                    }
                                  }),
                 std::runtime_error);
    EXPECT_THAT(sums, testing::ElementsAreArray(std::vector<long>(20, 4000)));
  }
}

TEST(Parallel, an_index_that_throws_leaves_no_nested_loop_undone) {
  for (int round = 0; round < kOften; ++round) {
    std::vector<long> sums(8, 4000);
    EXPECT_THROW(parallel::for_each(8,
                                    [&](std::size_t i) {
                                      if (i == 3) throw std::runtime_error("three");
                                      sums[i] = filled_in_parallel(4000);
                                    }),
                 std::runtime_error);
    EXPECT_THAT(sums, testing::Each(4000));
  }
}

// A user's own group of tasks may be cancelled while the library computes in it.
TEST(Parallel, a_group_that_is_cancelled_outside_does_not_matter) {
  tbb::task_group_context outside;
  long sum = 0;
  tbb::parallel_for(
      0, 1,
      [&](int) {
        outside.cancel_group_execution();
        sum = filled_in_parallel(4000);
      },
      outside);
  EXPECT_EQ(sum, 4000);
}

std::string message_of(const std::function<void()>& what) {
  try {
    what();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Parallel, the_first_exception_in_the_order_of_the_bodies_is_thrown) {
  const auto fail = [](const char* text) { throw std::runtime_error(text); };
  for (int round = 0; round < kOften; ++round) {
    EXPECT_EQ(message_of([&] {
                parallel::invoke([] {}, [&] { fail("second"); }, [&] { fail("third"); });
              }),
              "second");
    EXPECT_EQ(message_of([&] {
                parallel::for_each(1000, [&](std::size_t i) {
                  if (i % 100 == 37) fail(std::to_string(i).c_str());
                });
              }),
              "37");
  }
}

TEST(Parallel, nothing_to_do_is_done) {
  parallel::for_each(0, [](std::size_t) { FAIL(); });
  parallel::invoke([] {}, [] {});
}

}  // namespace
}  // namespace magimu
