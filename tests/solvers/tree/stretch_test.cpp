// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/stretch.h"

#include <gtest/gtest.h>

#include <random>

namespace magimu {
namespace {

constexpr int kNode = 3, kGlobals = 4;

CondensedTriangle triangle(int last, int first, std::mt19937& random) {
  std::normal_distribution<double> normal;
  CondensedTriangle t{last, first, kGlobals, {}, 0.0};
  t.R = RowBlock::Zero(t.width(), t.width() + 1);
  for (int i = 0; i < t.width(); ++i) {
    for (int j = i; j <= t.width(); ++j) t.R(i, j) = normal(random);
  }
  return t;
}

// Rows of a triangle among all unknowns.
void put(const CondensedTriangle& t, int row, int last, int first, int globals, MatrixXd& A) {
  A.block(row, last, t.width(), t.last) = t.R.leftCols(t.last);
  A.block(row, first, t.width(), t.first) = t.R.middleCols(t.last, t.first);
  A.block(row, globals, t.width(), t.globals) = t.R.middleCols(t.last + t.first, t.globals);
  A.block(row, A.cols() - 1, t.width(), 1) = t.R.col(t.width());
}

// Information and gradient at zero of the unknowns before the last column, all before `wanted`
// columns eliminated.
BlockScore dense(const MatrixXd& A, Eigen::Index wanted) {
  const Eigen::Index n = A.cols() - 1, rest = n - wanted;
  const MatrixXd N = A.leftCols(n).transpose() * A.leftCols(n);
  const VectorXd g = A.leftCols(n).transpose() * A.col(n);
  const MatrixXd solved = N.topLeftCorner(rest, rest).ldlt().solve(N.topRightCorner(rest, wanted));
  return {
      g.tail(wanted) - solved.transpose() * g.head(rest),
      N.bottomRightCorner(wanted, wanted) - solved.transpose() * N.topRightCorner(rest, wanted)};
}

// Two windows after a chain, beside another chain; two of the globals differ in the windows.
TEST(Stretch, what_a_difference_is_worth_is_that_of_all_rows_at_once) {
  std::mt19937 random(1);
  Stretch a, b;
  a.before = triangle(kNode, 0, random);
  a.others = triangle(0, 0, random);
  a.own = triangle(kNode, kNode, random);
  b = a;
  b.own = triangle(kNode, kNode, random);
  // [node 0 | node 1 | node 2 | globals | difference | d]
  const int globals = 3 * kNode, difference_at = globals + kGlobals, d = difference_at + 2;
  const int of_window = 2 * kNode + kGlobals;
  MatrixXd A = MatrixXd::Zero(kNode + kGlobals + kGlobals + 2 * of_window, d + 1);
  int row = 0;
  put(a.before, row, 0, 0, globals, A);
  row += a.before.width();
  put(a.others, row, 0, 0, globals, A);
  row += a.others.width();
  for (const int window : {1, 2}) {
    put(window == 1 ? a.own : b.own, row, window * kNode, (window - 1) * kNode, globals, A);
    A.block(row, difference_at, of_window, 1) = A.block(row, globals + 1, of_window, 1);
    A.block(row, difference_at + 1, of_window, 1) = A.block(row, globals + 3, of_window, 1);
    row += of_window;
  }
  const BlockScore want = dense(A, 2);
  const BlockScore got = difference(joined(a, b), {{1, 1}, {3, 1}});
  EXPECT_LT((got.information - want.information).norm(), 1e-9 * want.information.norm());
  EXPECT_LT((got.score - want.score).norm(), 1e-9 * want.score.norm());
}

TEST(Stretch, without_another_chain) {
  std::mt19937 random(2);
  Stretch a;
  a.before = triangle(kNode, 0, random);
  a.own = triangle(kNode, kNode, random);
  const int globals = 2 * kNode, d = globals + kGlobals + kGlobals;
  MatrixXd A = MatrixXd::Zero(a.before.width() + a.own.width(), d + 1);
  put(a.before, 0, 0, 0, globals, A);
  put(a.own, a.before.width(), kNode, 0, globals, A);
  A.block(a.before.width(), globals + kGlobals, a.own.width(), kGlobals) =
      A.block(a.before.width(), globals, a.own.width(), kGlobals);
  const BlockScore want = dense(A, kGlobals), got = difference(a, {{0, kGlobals}});
  EXPECT_LT((got.information - want.information).norm(), 1e-9 * want.information.norm());
  EXPECT_LT((got.score - want.score).norm(), 1e-9 * want.score.norm());
}

}  // namespace
}  // namespace magimu
