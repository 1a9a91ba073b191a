// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/condensed_triangle.h"

#include <algorithm>
#include <cmath>

#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kZeroPivot = 1e-12;  // of its row

// Rows begin <= i < end of a triangle into rows at.. of A: its columns last, first, globals and d
// go to the given columns.
void place(const CondensedTriangle& t, int begin, int end, RowStack& A, int at, int last, int first,
           int globals) {
  for (int i = begin; i < end; ++i, ++at) {
    const double* const from = t.R.data() + i * t.R.outerStride();
    double* const to = A.row(at);
    // Left of the diagonal there are zeros.
    const auto copy = [&](int column, int width, int target) {
      const int skip = std::min(width, std::max(0, i - column));
      std::copy_n(from + column + skip, width - skip, to + target + skip);
    };
    copy(0, t.last, last);
    copy(t.last, t.first, first);
    copy(t.last + t.first, t.globals, globals);
    to[A.columns() - 1] = from[t.width()];
  }
}

// Columns from `begin` on, of the rows listed (-1: a zero row).
RowBlock gather(const RowStack& A, const std::vector<int>& rows, int begin) {
  RowBlock out(Eigen::Index(rows.size()), A.columns() - begin);
  double* to = out.data();
  for (const int row : rows) {
    if (row < 0) {
      std::fill_n(to, out.cols(), 0.0);
    } else {
      std::copy_n(A.row(row) + begin, out.cols(), to);
    }
    to += out.cols();
  }
  return out;
}

// Squares of the last column from a row on.
double squares_below(const RowStack& A, int row) {
  double out = 0.0;
  for (; row < A.rows(); ++row) out += std::pow(A.row(row)[A.columns() - 1], 2);
  return out;
}

}  // namespace

VectorXd substitute(const Eigen::Ref<const RowBlock>& T, VectorXd b) {
  const Eigen::Index n = T.rows();
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    const double rest = b[i] + T.row(i).segment(i + 1, n - i - 1).dot(b.segment(i + 1, n - i - 1));
    const double pivot = T(i, i);
    b[i] = std::abs(pivot) <= kZeroPivot * T.row(i).norm() ? 0.0 : -rest / pivot;
  }
  return b;
}

VectorXd EliminatedNode::solve(const VectorXd& last_x, const VectorXd& first_x,
                               const VectorXd& globals_x) const {
  VectorXd b = R.col(R.cols() - 1);
  b += R.middleCols(width, last) * last_x;
  if (first > 0) b += R.middleCols(width + last, first) * first_x;
  b += R.middleCols(width + last + first, globals) * globals_x.head(globals);
  return substitute(R.leftCols(width), std::move(b));
}

CondensedTriangle merge(const CondensedTriangle& left, const CondensedTriangle& right, int globals,
                        EliminatedNode* shared) {
  const int b = left.last, c = right.last, a = left.first;
  CondensedTriangle out;
  out.last = c;
  out.first = a;
  out.globals = globals;
  out.squares = left.squares + right.squares;
  // [shared | last | first | globals | d], rows in the order that keeps the triangles' zeros.
  thread_local RowStack A;
  A.reset(left.width() + right.width(), b + c + a + globals + 1);
  const int g = b + c + a;
  int at = 0;
  const auto put = [&](const CondensedTriangle& t, int begin, int end, int last, int first) {
    place(t, begin, end, A, at, last, first, g);
    at += end - begin;
  };
  put(left, 0, b, 0, b + c);
  put(right, 0, c + b, b, 0);
  put(left, b, left.width(), 0, b + c);
  put(right, c + b, right.width(), b, 0);
  std::vector<int> shared_rows, rows;
  int next = triangularize(A, 0, 0, b, shared_rows);
  next = triangularize(A, next, b, g + globals, rows);
  out.squares += squares_below(A, next);
  out.R = gather(A, rows, b);
  if (shared != nullptr) *shared = {b, c, a, globals, gather(A, shared_rows, 0)};
  return out;
}

CondensedTriangle without_last(const CondensedTriangle& chain) {
  CondensedTriangle out;
  out.globals = chain.globals;
  out.squares = chain.squares;
  out.R = chain.R.bottomRightCorner(chain.globals, chain.globals + 1);
  return out;
}

CondensedTriangle sum(const CondensedTriangle& a, const CondensedTriangle& b, int globals) {
  CondensedTriangle out;
  out.globals = globals;
  out.squares = a.squares + b.squares;
  RowStack A(a.width() + b.width(), globals + 1);
  place(a, 0, a.width(), A, 0, 0, 0, 0);
  place(b, 0, b.width(), A, a.width(), 0, 0, 0);
  std::vector<int> rows;
  const int next = triangularize(A, 0, 0, globals, rows);
  out.squares += squares_below(A, next);
  out.R = gather(A, rows, 0);
  return out;
}

VectorXd solve(const CondensedTriangle& t, double tolerance) {
  const int n = t.globals;
  if (n == 0) return {};
  const auto T = t.R.leftCols(n);
  const VectorXd norms = T.colwise().norm().transpose();
  bool regular = true;
  for (int i = 0; i < n && regular; ++i) {
    regular = norms[i] > 0.0 && std::abs(T(i, i)) > 10.0 * tolerance * norms[i];
  }
  if (regular) return substitute(T, t.R.col(n));
  const VectorXd scale = norms.unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 1.0; });
  Eigen::JacobiSVD<MatrixXd> svd(T * scale.asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(tolerance / std::max(svd.singularValues()[0], 1e-300));
  return scale.cwiseProduct(svd.solve(-t.R.col(n)));
}

}  // namespace magimu
