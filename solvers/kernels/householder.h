// SPDX-License-Identifier: BSD-3-Clause
// Orthogonal triangularization of small dense blocks of rows, the step that everything in
// square-root form is made of (condensed_triangle.h, window_elimination.h). Reflections leave alone
// the rows that are zero in the pivot's column, so that stacked triangles cost what their entries
// cost, not what the rectangle around them would.
#pragma once

#include <vector>

#include "graph/scalar.h"
#include "solvers/kernels/aligned_buffer.h"

namespace magimu {

// Row by row, so that rows are stacked by copying and a reflection runs along memory.
using RowBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Rows to be triangularized, in memory as SIMD registers like them: each begins on 64 bytes, with
// zeros behind the last column up to where the next one begins.
class RowStack {
 public:
  using View = Eigen::Map<RowBlock, Eigen::Unaligned, Eigen::OuterStride<>>;

  RowStack() = default;
  RowStack(int rows, int columns) { reset(rows, columns); }
  // So many rows of zeros; memory is kept.
  void reset(int rows, int columns);
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  double* row(int i) { return numbers_.data() + i * stride_; }
  const double* row(int i) const { return numbers_.data() + i * stride_; }
  View view() { return {numbers_.data(), rows_, columns_, Eigen::OuterStride<>(stride_)}; }

 private:
  friend int triangularize(RowStack& A, int top, int begin, int end, std::vector<int>& pivot_row);
  int rows_ = 0, columns_ = 0;
  Eigen::Index stride_ = 0;
  AlignedBuffer numbers_, work_;
  std::vector<int> integers_;
};

// Householder reflections of the rows from `top` on, which are zero left of column `begin`: columns
// begin <= j < end are zero below their pivot afterwards. pivot_row[j - begin] is the row that
// holds pivot j: top, top + 1, ... in order; or -1 where the column was zero already (to 1e-13 of
// its norm), which uses up no row. Returns the first row below the pivots'.
int triangularize(RowStack& A, int top, int begin, int end, std::vector<int>& pivot_row);
int triangularize(RowBlock& A, int top, int begin, int end, std::vector<int>& pivot_row);

}  // namespace magimu
