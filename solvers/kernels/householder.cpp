// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/householder.h"

#include <algorithm>

#include "solvers/kernels/rank_update.h"

namespace magimu {

void RowStack::reset(int rows, int columns) {
  rows_ = rows;
  columns_ = columns;
  stride_ = lanes::padded(columns);
  const auto size = std::size_t(rows * stride_);
  if (numbers_.size() < size) {
    numbers_ = AlignedBuffer(size);
  } else {
    std::fill_n(numbers_.data(), size, 0.0);
  }
}

int triangularize(RowStack& A, int top, int begin, int end, std::vector<int>& pivot_row) {
  static const lanes::RankCode code = lanes::rank_code(best_isa());
  pivot_row.assign(std::size_t(end - begin), -1);
  if (A.rows_ == top) return top;
  const auto numbers = std::size_t(2 * (A.stride_ + A.rows_));
  if (A.work_.size() < numbers) A.work_ = AlignedBuffer(numbers, AlignedBuffer::Fill::kNone);
  A.integers_.resize(std::size_t(end - begin + 3 * A.rows_));
  return code.triangularize(A.numbers_.data(), A.stride_, A.rows_, top, begin, end,
                            pivot_row.data(), A.work_.data(), A.integers_.data());
}

int triangularize(RowBlock& A, int top, int begin, int end, std::vector<int>& pivot_row) {
  RowStack rows(int(A.rows()), int(A.cols()));
  rows.view() = A;
  const int below = triangularize(rows, top, begin, end, pivot_row);
  A = rows.view();
  return below;
}

}  // namespace magimu
