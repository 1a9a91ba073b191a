// SPDX-License-Identifier: BSD-3-Clause
// What condensed windows leave: the nodes between them, each coupled to its neighbours, and the
// globals. Few unknowns, eliminated one after the other to the root, the globals' own triangle.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "solvers/window_layout.h"

namespace magimu::lanes {

class BoundaryChain {
 public:
  explicit BoundaryChain(const Layout& layout);

  // Forgets everything.
  void clear();
  // A window's Sweep::out, of one lane.
  void add(int window, const double* out, int lane, int lanes);
  // Rows [J | r] of a factor on globals alone, with the globals' columns.
  void add_global(const std::vector<int>& columns, int rows, const double* J);
  // Eliminates down to the root, with this damping; false if that is singular.
  bool eliminate(double damping);
  // Steps of globals and boundaries. Call after eliminate().
  void solve();

  // Boundary nodes: those of window w are boundary_of(w) and the next.
  int boundary_of(int window) const { return first_[std::size_t(window)]; }
  int boundaries() const { return int(chain_begins_.size()); }
  const double* delta(int boundary) const { return delta_.data() + std::size_t(boundary * d_); }
  const VectorXd& delta_globals() const { return delta_globals_; }
  // Diagonal of the information before elimination.
  const double* diagonal(int boundary) const {
    return diagonal_.data() + std::size_t(boundary * d_);
  }
  const VectorXd& diagonal_globals() const { return root_diagonal_; }
  // The globals' information, everything else eliminated, as damped at eliminate().
  const MatrixXd& root() const { return damped_root_; }

  double squares() const { return squares_; }  // of all residuals
  double gained() const { return gained_; }    // |L^-1 gradient|^2 of all eliminated unknowns
  double gradient() const;  // sum of gradient^2 / diagonal, boundaries and globals
  double smallest_pivot() const { return pivot_; }
  // Sums over boundaries and globals of diagonal * delta^2 and delta^2.
  double sum_damped() const;
  double sum_squares() const;

 private:
  void eliminate_boundary(int i, double damping);
  double* row(std::vector<double>& rows, int boundary, int i) const {
    return rows.data() + std::size_t((boundary * d_ + i) * wide());
  }
  int wide() const { return 2 * d_ + g_ + 1; }

  int d_, g_, b_;
  std::vector<int> first_;          // boundary of each window
  std::vector<char> chain_begins_;  // of each boundary
  // Of each boundary, as gathered and as eliminated: rows [own | next | globals, residual].
  std::vector<double> gathered_, rows_, inverse_;
  std::vector<double> diagonal_, gradient_, delta_;
  MatrixXd root_, damped_root_;  // globals and residual
  VectorXd root_diagonal_, root_gradient_, delta_globals_;
  Eigen::LLT<MatrixXd> llt_;
  double squares_ = 0.0, gained_ = 0.0, pivot_ = 1.0;
};

}  // namespace magimu::lanes
