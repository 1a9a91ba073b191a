// SPDX-License-Identifier: BSD-3-Clause
// Windows that fall asleep: the estimate is the same as if all stayed awake, to the last bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sstream>

#include "graph/linear_system.h"
#include "solvers/marginals.h"
#include "solvers/tree/incremental_qr.h"
#include "tests/solvers/windowed.h"

namespace magimu {
namespace {

using test::is_global;
using test::Stream;

// Two estimators of the same stream: one whose windows fall asleep, one whose do not.
struct Pair {
  explicit Pair(const Stream& stream)
      : s(stream), sleeping(options()), awake({.is_global = is_global, .eager_windows = 10}) {}
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  IncrementalQrOptions options() {
    return {.is_global = is_global,
            .eager_windows = 10,
            .make_again =
                [this](int window) {
                  ++made;
                  const Stream::Window& w = s.windows[std::size_t(window)];
                  return WindowParts{w.factors, w.removable};
                },
            .awake = 8};
  }
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

// As windows before it left it, and with windows after it.
TEST(IncrementalSleep, what_was_saved_goes_on_with_the_same_bits) {
  for (const Stream& s :
       {test::rotations_in_windows(5, 300, 3), test::rotations_in_windows(6, 360, 3, 3),
        test::hand_held_in_windows(7, 240, 4)}) {
    Pair p(s);
    const auto feed = [&](IncrementalQr& e, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Stream::Window& w = s.windows[i];
        const int window = e.update(w.factors, w.values, w.removable, i >= 5).window;
        if (i >= 5) e.conclude(window, i % 9 != 0);
      }
    };
    const std::size_t half = s.windows.size() / 2;
    p.both([&](IncrementalQr& e) { feed(e, 0, half); });
    std::stringstream kept;
    ByteWriter out(kept);
    ASSERT_TRUE(p.sleeping.save(out));
    ASSERT_TRUE(out.finish());
    ASSERT_TRUE(is_whole(kept));
    ByteReader in(kept);
    p.sleeping = IncrementalQr(p.options());
    p.sleeping.load(in);
    p.expect_same_bits();
    p.both([&](IncrementalQr& e) {
      feed(e, half, s.windows.size());
      e.restore(9);
    });
    p.expect_same_bits();
  }
}

TEST(IncrementalSleep, what_is_damaged_is_not_whole) {
  std::stringstream kept;
  ByteWriter out(kept);
  for (int i = 0; i < 20000; ++i) out.put(0.5 * i);
  ASSERT_TRUE(out.finish());
  const std::string bytes = kept.str();
  for (const std::size_t at : {std::size_t(0), std::size_t(70000), bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = char(damaged[at] ^ 16);
    std::stringstream in(damaged);
    EXPECT_FALSE(is_whole(in)) << at;
    std::stringstream cut(bytes.substr(0, at));
    EXPECT_FALSE(is_whole(cut)) << at;
  }
}

// Of all blocks together: no score at the optimum, and the information of the root. The robust
// covariance is that of the same blocks of rows in the graph of all windows.
TEST(IncrementalSleep, scores_of_windows_are_those_of_their_rows) {
  const Stream s = test::hand_held_in_windows(8, 320, 8);
  Pair p(s);
  for (const Stream::Window& w : s.windows) p.sleeping.update(w.factors, w.values, w.removable);
  for (int i = 0; i < 4; ++i) p.sleeping.idle();
  std::vector<Key> keys;
  std::vector<int> block;
  for (const Values::Slot& slot : p.sleeping.globals().slots()) keys.push_back(slot.key);
  for (int w = 0; w < p.sleeping.windows(); ++w) block.push_back(w / 2);
  const int blocks = block.back() + 1;
  const std::vector<BlockScore> scores = p.sleeping.scores(block, blocks);
  const MatrixXd A = p.sleeping.information(keys), P = p.sleeping.covariance(keys);
  VectorXd score = VectorXd::Zero(A.rows());
  MatrixXd information = MatrixXd::Zero(A.rows(), A.cols());
  for (const BlockScore& b : scores) {
    score += b.score;
    information += b.information;
  }
  EXPECT_LT(score.dot(P * score), 1e-8);
  EXPECT_LT((information - A).norm(), 1e-9 * A.norm());

  const Values at = p.sleeping.estimate();
  const FactorGraph graph = p.sleeping.graph();
  LinearSystem system(graph, at);
  system.linearize(at);
  std::vector<int> block_of_row(std::size_t(system.rows()), -1);
  std::size_t batch = 0;
  for (std::size_t w = 0; w < s.windows.size(); ++w) {
    for (const FactorGraph* part : {&s.windows[w].factors, &s.windows[w].removable}) {
      for (const auto& own : part->batches()) {
        const auto begin = block_of_row.begin() + system.first_row(batch++);
        std::fill_n(begin, own->rows() * own->size(), block[w]);
      }
    }
  }
  const Marginals marginals(graph, at);
  const MatrixXd H = marginals.determined_columns(keys);
  const MatrixXd robust = sandwich_covariance(system, H, P, block_of_row, blocks);
  EXPECT_LT((sandwich_covariance(P, scores) - robust).norm(), 1e-4 * robust.norm());
}

}  // namespace
}  // namespace magimu
