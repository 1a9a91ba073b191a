// SPDX-License-Identifier: BSD-3-Clause
// A sum of products row' row of many rows, which are gathered and multiplied many at once.
#pragma once

#include "solvers/kernels/aligned_buffer.h"
#include "solvers/kernels/rank_update.h"

namespace magimu {

class SquareSum {
 public:
  explicit SquareSum(int columns);

  // No row, as at first.
  void clear();
  int columns() const { return columns_; }
  // Length of a row: its columns, and zeros.
  int width() const { return width_; }
  // Places for `count` rows that will be part of the sum; they follow each other, all zero.
  double* rows(int count);
  // The sum less the products of other rows.
  void subtract(const double* rows, int count);
  // Takes in what has been gathered.
  void finish();
  // Of the sum so far; i <= j.
  double operator()(int i, int j) const {
    return square_[std::size_t(i) * std::size_t(width_) + std::size_t(j)];
  }
  double& operator()(int i, int j) {
    return square_[std::size_t(i) * std::size_t(width_) + std::size_t(j)];
  }

 private:
  lanes::RankCode code_;
  int columns_, width_, filled_ = 0;
  AlignedBuffer square_, rows_;
};

}  // namespace magimu
