// SPDX-License-Identifier: BSD-3-Clause
// Windows that fall asleep: the estimate is the same as if all stayed awake, to the last bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "solvers/incremental_qr.h"
#include "tests/solvers/windowed.h"

namespace magimu {
namespace {

using test::is_global;
using test::Stream;

// Two estimators of the same stream: one whose windows fall asleep, one whose do not.
struct Pair {
  explicit Pair(const Stream& stream)
      : s(stream),
        sleeping({.is_global = is_global,
                  .eager_windows = 10,
                  .make_again =
                      [this](int window) {
                        ++made;
                        const Stream::Window& w = s.windows[std::size_t(window)];
                        return WindowParts{w.factors, w.removable};
                      },
                  .awake = 8}),
        awake({.is_global = is_global, .eager_windows = 10}) {}
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  template <class Body>
  void both(const Body& body) {
    body(sleeping);
    body(awake);
  }
  void expect_same_bits() const {
    EXPECT_THAT(sleeping.globals().data(), testing::ElementsAreArray(awake.globals().data()));
    EXPECT_EQ(sleeping.cost(), awake.cost());
    EXPECT_TRUE(std::ranges::equal(sleeping.front().data(), awake.front().data()));
    EXPECT_TRUE(std::ranges::equal(sleeping.estimate().data(), awake.estimate().data()));
    EXPECT_EQ(sleeping.graph().size(), awake.graph().size());
  }

  const Stream& s;
  int made = 0;
  IncrementalQr sleeping, awake;
};

void expect_same_estimates(const Stream& s) {
  Pair p(s);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < s.windows.size(); ++i) {
    const Stream::Window& w = s.windows[i];
    const bool take_in = random() % 8 != 0;
    const int again = int(random() % (i + 1));
    p.both([&](IncrementalQr& e) {
      const int window = e.update(w.factors, w.values, w.removable, i >= 5).window;
      if (i >= 5) e.conclude(window, take_in);
      if (!e.removed(again)) return;
      e.innovation(again);
      e.restore(again);
    });
    EXPECT_EQ(p.sleeping.cost(), p.awake.cost()) << i;
  }
  p.expect_same_bits();
  p.both([](IncrementalQr& e) {
    e.remove(3);
    for (int i = 0; i < 3; ++i) e.idle();
  });
  EXPECT_GT(p.made, int(s.windows.size()) / 2) << "no window has slept";
  p.expect_same_bits();
  EXPECT_EQ(p.sleeping.innovation(7).squares, p.awake.innovation(7).squares);
}

TEST(IncrementalSleep, a_chain_of_rotations_ends_at_the_same_bits) {
  expect_same_estimates(test::rotations_in_windows(1, 600, 3));
}

TEST(IncrementalSleep, nodes_with_velocity_and_position_end_at_the_same_bits) {
  expect_same_estimates(test::hand_held_in_windows(2, 360, 4));
}

TEST(IncrementalSleep, several_chains_end_at_the_same_bits) {
  expect_same_estimates(test::rotations_in_windows(3, 480, 4, 3));
}

TEST(IncrementalSleep, windows_at_once_end_at_the_same_bits) {
  const Stream s = test::rotations_in_windows(4, 600, 3);
  Pair p(s);
  p.both([&](IncrementalQr& e) {
    for (const Stream::Window& w : s.windows) e.append(w.factors, w.values, w.removable);
    for (int i = 0; i < 3; ++i) e.idle();
  });
  EXPECT_GT(p.made, 100);
  p.expect_same_bits();
}

}  // namespace
}  // namespace magimu
