// SPDX-License-Identifier: BSD-3-Clause
// Parallel loops and branches whose exceptions stay where they arose. TBB cancels the whole group
// when one body throws, and with it every loop that other bodies have started: such a loop returns
// as if it were done, and whoever called it goes on with arrays that were never filled. Here each
// body runs to its own end, each call is a group of its own, which nothing outside can cancel, and
// the exception of the first body, in their order, is thrown when all have ended. So which
// exception it is does not depend on the number of threads either.
//
// With MAGIMU_PLAIN_THREADS the bodies run in plain threads: for ThreadSanitizer, which does not
// see how TBB hands tasks over (./dev tsan).
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <mutex>
#include <tuple>

#ifdef MAGIMU_PLAIN_THREADS
#include <atomic>
#include <thread>
#include <vector>
#else
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_group.h>
#endif

namespace magimu::parallel {
namespace detail {

// The exception of the body that comes first in their order.
class FirstFailure {
 public:
  template <class Body>
  void guard(std::size_t place, const Body& body) {
    try {
      body();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_ || place < place_) {
        failure_ = std::current_exception();
        place_ = place;
      }
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr failure_;
  std::size_t place_ = 0;
};

// share(begin, end) for stretches of 0 .. n-1, at least `grain` long but for the last; none throws.
template <class Share>
void divide(std::size_t n, std::size_t grain, const Share& share) {
#ifdef MAGIMU_PLAIN_THREADS
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t begin = next.fetch_add(grain); begin < n; begin = next.fetch_add(grain)) {
      share(begin, std::min(begin + grain, n));
    }
  };
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < std::min<std::size_t>(4, (n + grain - 1) / grain); ++i) {
    others.emplace_back(work);
  }
  work();
#else
  tbb::task_group_context alone(tbb::task_group_context::isolated);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, n, grain),
      [&](const tbb::blocked_range<std::size_t>& range) { share(range.begin(), range.end()); },
      tbb::auto_partitioner(), alone);
#endif
}

}  // namespace detail

// body(i) for i = 0 .. n-1, at least `grain` of them by one task. A body that throws ends the rest
// of its task's share.
template <class Body>
void for_each(std::size_t n, std::size_t grain, const Body& body) {
  detail::FirstFailure failure;
  detail::divide(n, grain, [&](std::size_t begin, std::size_t end) {
    failure.guard(begin, [&] {
      for (std::size_t i = begin; i != end; ++i) body(i);
    });
  });
  failure.rethrow();
}
template <class Body>
void for_each(std::size_t n, const Body& body) {
  for_each(n, 1, body);
}

// All branches side by side.
template <class... Branches>
void invoke(const Branches&... branches) {
  detail::FirstFailure failure;
  std::size_t place = 0;
  // Braces: numbered in this order.
  const std::tuple guarded{
      [&failure, &branches, place = place++] { failure.guard(place, branches); }...};
  std::apply(
      [](const auto&... run) {
#ifdef MAGIMU_PLAIN_THREADS
        const std::jthread threads[] = {std::jthread(run)...};
#else
        tbb::task_group_context alone(tbb::task_group_context::isolated);
        tbb::parallel_invoke(run..., alone);
#endif
      },
      guarded);
  failure.rethrow();
}

}  // namespace magimu::parallel
