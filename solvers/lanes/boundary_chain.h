// SPDX-License-Identifier: BSD-3-Clause
// The unknowns that remain when windows have been condensed: the boundary nodes between them, each
// coupled to its neighbours, and the globals. The boundaries are eliminated one after the other,
// until the root is left, which has the globals alone. The form is that of the windows.
#pragma once

#include <memory>
#include <vector>

#include "solvers/lanes/window_layout.h"

namespace magimu::lanes {

class BoundaryChain {
 public:
  static std::unique_ptr<BoundaryChain> make(const Layout& layout, EliminationForm form);
  virtual ~BoundaryChain() = default;

  // Forgets everything.
  virtual void clear();
  // A window's Sweep::out, of one lane, without the sums that it begins with.
  virtual void add(int window, const double* out, int lane, int lanes) = 0;
  // Adds a window's norms, one lane of what a sweep leaves (norm_doubles() in lane_sweep.h).
  void add_norms(int window, const double* norms, int lane, int lanes);
  // A factor of globals alone: J has its rows [J | r], columns are their places among the globals.
  virtual void add_global(const std::vector<int>& columns, int rows, const double* J);
  // Eliminates down to the root, with this damping; false if that is singular.
  virtual bool eliminate(double damping) = 0;
  // Steps of the boundaries, the globals' being known. Call after eliminate().
  void solve();

  // The boundary nodes of window w are boundary_of(w) and the next.
  int boundary_of(int window) const { return first_[std::size_t(window)]; }
  int boundaries() const { return int(chain_begins_.size()); }
  const double* delta(int boundary) const { return delta_.data() + std::size_t(boundary * d_); }
  const VectorXd& delta_globals() const { return delta_globals_; }
  // Diagonal of the information before elimination.
  const double* diagonal(int boundary) const {
    return diagonal_.data() + std::size_t(boundary * d_);
  }
  const VectorXd& diagonal_globals() const { return root_diagonal_; }
  // Inverse of the globals' information, everything else eliminated, as damped at eliminate().
  virtual MatrixXd covariance_globals() const = 0;

  double squares() const { return squares_; }  // of all residuals
  double gained() const { return gained_; }    // |L^-1 gradient|^2 of all eliminated unknowns
  double gradient() const;  // sum of gradient^2 / diagonal, boundaries and globals
  double smallest_pivot() const { return pivot_; }
  // Sums over boundaries and globals of diagonal * delta^2 and delta^2.
  double sum_damped() const;
  double sum_squares() const;

 protected:
  explicit BoundaryChain(const Layout& layout);
  double* row(std::vector<double>& rows, int boundary, int i) const {
    return rows.data() + std::size_t((boundary * d_ + i) * wide());
  }
  int wide() const { return 2 * d_ + g_ + 1; }
  static double positive(double diagonal) { return diagonal > 0.0 ? diagonal : 1.0; }
  double positive_diagonal(int boundary, int i) const {
    return positive(diagonal_[std::size_t(boundary * d_ + i)]);
  }
  // Is there a window from this boundary to the next?
  bool linked(int boundary) const {
    return boundary + 1 < boundaries() && chain_begins_[std::size_t(boundary) + 1] == 0;
  }
  // Factors that scale the root's columns to unit norm, damping included.
  VectorXd root_scale(double damping) const;

  int d_, g_, b_;  // columns of a node, of the globals, of a window's border (lane_sweep.h)
  std::vector<double> rows_, inverse_;  // eliminated: [own | next | globals, residual]; 1 / pivot
  std::vector<double> diagonal_, gradient_, delta_;
  VectorXd root_diagonal_, root_gradient_, delta_globals_;
  double squares_ = 0.0, gained_ = 0.0, pivot_ = 1.0;

 private:
  std::vector<int> first_;          // boundary of each window
  std::vector<char> chain_begins_;  // of each boundary: does a chain begin there?
};

}  // namespace magimu::lanes
