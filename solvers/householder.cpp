// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/householder.h"

#include <algorithm>
#include <cmath>

#include "solvers/rank_update.h"

namespace magimu {
namespace {

constexpr double kZeroColumn = 1e-13;

// As RankCode::reflect, of a few columns.
void reflect_few(double* first, std::ptrdiff_t stride, const int* list, int rows, const double* v,
                 double beta, int columns) {
  for (int c = 0; c < columns; ++c) {
    double w = 0.0;
    for (int k = 0; k < rows; ++k) w += v[k] * first[list[k] * stride + c];
    for (int k = 0; k < rows; ++k) first[list[k] * stride + c] -= beta * w * v[k];
  }
}

}  // namespace

int triangularize(RowBlock& A, int top, int begin, int end, std::vector<int>& pivot_row) {
  static const lanes::RankCode code = lanes::rank_code(best_isa());
  const int rows = int(A.rows()), columns = int(A.cols());
  pivot_row.assign(std::size_t(end - begin), -1);
  if (rows == top) return top;
  // Row by row, along memory: squared norms of the columns, and where each row begins.
  std::vector<double> scale(std::size_t(end - begin), 0.0);
  std::vector<int> first(std::size_t(rows), begin);
  for (int i = top; i < rows; ++i) {
    const double* const row = A.data() + i * A.outerStride() + begin;
    for (std::size_t c = 0; c < scale.size(); ++c) scale[c] += row[c] * row[c];
    while (first[std::size_t(i)] < end && row[first[std::size_t(i)] - begin] == 0.0) {
      ++first[std::size_t(i)];
    }
  }
  std::vector<int> list(std::size_t(rows), 0);
  std::vector<double> v(std::size_t(rows), 0.0);
  for (int j = begin; j < end && top < rows; ++j) {
    double below = 0.0;
    int active = 1;
    list[0] = top;
    for (int i = top + 1; i < rows; ++i) {
      if (first[std::size_t(i)] > j) continue;
      const double x = A(i, j);
      if (x == 0.0) continue;
      list[std::size_t(active)] = i;
      v[std::size_t(active++)] = x;
      below += x * x;
    }
    const double head = A(top, j), norm2 = head * head + below;
    if (norm2 <= kZeroColumn * kZeroColumn * scale[std::size_t(j - begin)]) {
      A.block(top, j, rows - top, 1).setZero();
      continue;
    }
    if (below > 0.0) {
      const double norm = std::sqrt(norm2), pivot = head > 0.0 ? -norm : norm;
      v[0] = head - pivot;
      const double beta = 2.0 / (v[0] * v[0] + below);
      // Whole packs up to the last column; those that begin before j find zeros there.
      int wide = lanes::padded(columns - j);
      if (columns - wide < begin) wide -= lanes::kWidthUnit;
      const int from = columns - wide;
      code.reflect(A.data() + from, A.outerStride(), list.data(), active, v.data(), beta, wide);
      reflect_few(A.data() + j, A.outerStride(), list.data(), active, v.data(), beta,
                  std::max(0, from - j));
      for (int k = 1; k < active; ++k) A(list[std::size_t(k)], j) = 0.0;
      A(top, j) = pivot;
    }
    pivot_row[std::size_t(j - begin)] = top++;
  }
  return top;
}

}  // namespace magimu
