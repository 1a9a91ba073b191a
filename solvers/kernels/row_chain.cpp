// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/row_chain.h"

#include <algorithm>
#include <cmath>

namespace magimu {

double log_det_of_pivots(const RowStack& A, int begin, const std::vector<int>& pivots) {
  double out = 0.0;
  for (std::size_t p = 0; p < pivots.size(); ++p) {
    if (pivots[p] >= 0) out += 2.0 * std::log(std::abs(A.row(pivots[p])[begin + int(p)]));
  }
  return out;
}

void add_rows(const RowStack& A, int begin, int end, int skip, SquareSum& sum) {
  if (end <= begin) return;
  double* to = sum.rows(end - begin);
  for (int i = begin; i < end; ++i, to += sum.width()) {
    std::copy_n(A.row(i) + skip, sum.columns(), to);
  }
}

void RowChain::reset(int border, int kept) {
  border_ = border;
  kept_ = kept;
  node_ = next_ = 0;
  begin_chain();
}

RowStack& RowChain::stack(int node, int next, int more) {
  const RowStack& before = rows();
  first_row_ = carried_end_ - carried_begin_;
  RowStack& now = stacks_[1 - now_];
  now.reset(first_row_ + more, node + next + border_);
  for (int i = 0; i < first_row_; ++i) {
    const double* const from = before.row(carried_begin_ + i) + node_;
    std::copy_n(from, next_, now.row(i));
    std::copy_n(from + next_, border_, now.row(i) + node + next);
  }
  now_ = 1 - now_;
  node_ = node;
  next_ = next;
  return now;
}

void RowChain::eliminate() {
  carried_begin_ = triangularize(rows(), 0, 0, node_, pivots_);
  carried_end_ = triangularize(rows(), carried_begin_, node_, node_ + next_ + kept_, next_pivots_);
}

}  // namespace magimu
