// SPDX-License-Identifier: BSD-3-Clause
// Boundaries and root in the information form (bordered_chain.h). Nothing is decided about rank
// here: where a pivot may be rounding, the square-root form must serve (square_root_chain.h).
#pragma once

#include "graph/decompositions.h"
#include "solvers/kernels/bordered_chain.h"
#include "solvers/lanes/boundary_chain.h"

namespace magimu::lanes {

class InformationChain final : public BoundaryChain {
 public:
  explicit InformationChain(const Layout& layout);

  void clear() override;
  void add(int window, const double* out, int lane, int lanes) override;
  void add_global(const std::vector<int>& columns, int rows, const double* J) override;
  bool eliminate(double damping) override;
  MatrixXd covariance_globals() const override;

 private:
  void enter(int boundary, double damping);
  void eliminate_boundary(int boundary, double damping);

  std::vector<double> gathered_;  // rows_ before elimination
  BorderedChain chain_;
  MatrixXd root_;  // globals and residual
  VectorXd scale_;
  Eigen::LLT<MatrixXd> llt_;
};

}  // namespace magimu::lanes
