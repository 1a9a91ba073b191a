// SPDX-License-Identifier: BSD-3-Clause
// A chain of nodes being eliminated one after the other, each coupled to its neighbours and to a
// wide border of columns that stay. Information form: with [A C; C' A_next] that of two neighbours
// and B that between a node and the border (the square-root form is row_chain.h),
//
//   U'U = A,  W = U'^-1 C,  V = U'^-1 B,    A_next -= W'W,  B_next -= W'V,  border -= V'V
#pragma once

#include <vector>

#include "solvers/kernels/square_sum.h"

namespace magimu {

class BorderedChain {
 public:
  // Of a diagonal before anything was eliminated: a pivot so small is taken for rounding, and its
  // direction for free.
  static constexpr double kTiny = 1e-12;
  // max_dim: of a node. tiny: 0 where no direction may be free; then least_pivot() tells.
  BorderedChain(int border, int max_dim, double tiny = kTiny);
  // Begins anew.
  void clear();

  // The next node, of `dim` unknowns, with no information as yet; the one before the last must have
  // been eliminated.
  void push(int dim);
  // The first columns of the border become a node before the one that is there (none or one), whose
  // rows have zeros there from then on; the border must be finished, its square keeps the columns.
  // diagonal: theirs before anything was eliminated.
  void pull(const std::vector<double>& diagonal);
  // Eliminates the older one of two nodes, or the last one.
  void eliminate() {
    factorize();
    drop();
  }
  // The two halves of it: until drop() the node's information(i, j) and row(i) are [U W] and V.
  void factorize();
  void drop();
  // 1 / U_ii between the two; 0 of a direction that is free.
  double inverse(int i) const { return inverse_[std::size_t(i)]; }

  // The nodes that are there, two at most, their unknowns one after another.
  int nodes() const { return nodes_; }
  int older() const { return older_; }  // unknowns of the first of two nodes
  int unknowns() const { return older_ + newer_; }
  double& information(int i, int j) { return A_[std::size_t(i * stride_ + j)]; }  // i <= j
  int stride() const { return stride_; }  // from one row of it to the next
  // What earlier eliminations have taken from a diagonal.
  double& taken(int i) { return taken_[std::size_t(i)]; }
  // Row i of B; border().width() numbers.
  double* row(int i);

  // The border's own information.
  SquareSum& border() { return border_; }
  const SquareSum& border() const { return border_; }
  // Takes in what has been gathered.
  void finish();
  // Logarithm of the determinant of what was eliminated, without directions that were free.
  double log_det() const { return log_det_; }
  // The smallest pivot, over its diagonal before anything was eliminated; at most 1.
  double least_pivot() const { return least_pivot_; }

 private:
  void factorize(int n, int all);
  void subtract();
  int eliminating() const { return nodes_ > 1 ? older_ : newer_; }

  lanes::RankCode code_;
  double tiny_;
  SquareSum border_;
  int stride_;  // of A
  std::vector<double> A_, taken_, inverse_;
  AlignedBuffer rows_;  // V of what was eliminated lately, then B of the nodes that are there
  int eliminated_ = 0, nodes_ = 0, older_ = 0, newer_ = 0;
  double log_det_ = 0.0, least_pivot_ = 1.0;
};

}  // namespace magimu
