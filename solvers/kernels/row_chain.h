// SPDX-License-Identifier: BSD-3-Clause
// A chain of nodes being eliminated one after the other, each coupled to the next and to a border
// of columns that stay. Square-root form: reflections of the rows that touch a node. The
// information form is bordered_chain.h.
#pragma once

#include <vector>

#include "solvers/kernels/householder.h"
#include "solvers/kernels/square_sum.h"

namespace magimu {

// Logarithm of the determinant of R'R, R the rows that hold the pivots of columns begin, begin + 1,
// ... (triangularize()); columns without a pivot are left out.
double log_det_of_pivots(const RowStack& A, int begin, const std::vector<int>& pivots);
// Adds rows begin <= i < end of A, from column `skip` on.
void add_rows(const RowStack& A, int begin, int end, int skip, SquareSum& sum);

class RowChain {
 public:
  RowChain() = default;
  explicit RowChain(int border, int kept = 0) { reset(border, kept); }
  // Another chain; memory is kept. kept: so many of the border's first columns are reduced with the
  // next node's, and rows on them alone are carried on, too.
  void reset(int border, int kept = 0);
  // A chain begins with the same border: nothing is carried on.
  void begin_chain() { carried_begin_ = carried_end_ = 0; }

  // Rows over [node | next | border]: those that were carried on from earlier nodes, then `more`
  // rows of zeros from first_row() on, for the caller to fill. Carried rows are in the node's first
  // columns; next: 0 where there is none.
  RowStack& stack(int node, int next, int more);
  int first_row() const { return first_row_; }

  // Eliminates the node. Its rows are then those before end_of_node(); rows up to end_of_next() are
  // carried on; rows from there on say nothing of nodes. All of them stay until the next stack().
  void eliminate();
  int end_of_node() const { return carried_begin_; }
  int end_of_next() const { return carried_end_; }
  // Which row holds each of the node's columns' pivot; -1: none.
  const std::vector<int>& pivots() const { return pivots_; }
  // Logarithm of the determinant of the information that the node had, and of what the next node
  // has by now, without directions that are free.
  double log_det() const { return log_det_of_pivots(rows(), 0, pivots_); }
  double log_det_of_next() const { return log_det_of_pivots(rows(), node_, next_pivots_); }
  // [next | border].
  auto carried() {
    return rows().view().block(carried_begin_, node_, carried_end_ - carried_begin_,
                               rows().columns() - node_);
  }

 private:
  RowStack& rows() { return stacks_[now_]; }
  const RowStack& rows() const { return stacks_[now_]; }

  RowStack stacks_[2];  // this node's rows; those of the node before, or room
                        // for the next one's
  std::size_t now_ = 0;
  int border_ = 0, kept_ = 0, node_ = 0, next_ = 0, first_row_ = 0;
  int carried_begin_ = 0, carried_end_ = 0;
  std::vector<int> pivots_, next_pivots_;
};

}  // namespace magimu
