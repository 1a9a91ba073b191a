// SPDX-License-Identifier: BSD-3-Clause
// Boundaries and root in the square-root form: triangles of rows, stacked and reduced by
// Householder reflections (householder.h), windows in their order. Rank is decided by a
// column-pivoted factorization of the root's triangle.
#pragma once

#include "graph/decompositions.h"
#include "solvers/kernels/row_chain.h"
#include "solvers/lanes/boundary_chain.h"

namespace magimu::lanes {

class SquareRootChain final : public BoundaryChain {
 public:
  explicit SquareRootChain(const Layout& layout);

  void clear() override;
  void add(int window, const double* out, int lane, int lanes) override;
  void add_global(const std::vector<int>& columns, int rows, const double* J) override;
  bool eliminate(double damping) override;
  MatrixXd covariance_globals() const override;

 private:
  // Rows on the globals and their residual: a triangle on top, others below until there are many.
  struct Root {
    RowBlock rows;
    int filled = 0;
    double* next();  // a row of zeros
    void reduce();
  };
  bool eliminate_boundary(int boundary, double damping);

  std::vector<double> gathered_;  // of the window from each boundary: 2 d rows like rows_
  Root gathered_root_, root_;
  double gathered_gain_ = 0.0;  // of inner nodes
  RowChain chain_;
  VectorXd scale_;
  Eigen::ColPivHouseholderQR<MatrixXd> qr_;
};

}  // namespace magimu::lanes
