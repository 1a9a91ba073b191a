// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/whitener.h"

#include <cmath>

#include "graph/decompositions.h"

namespace magimu {

MatrixXd whitener(const MatrixXd& A, double invisible) {
  if (A.rows() == 0) return MatrixXd(0, 0);
  const VectorXd scale =
      A.diagonal().unaryExpr([](double a) { return a > 0.0 ? 1.0 / std::sqrt(a) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(scale.asDiagonal() * A * scale.asDiagonal()));
  const VectorXd& values = eigen.eigenvalues();
  const double largest = values.maxCoeff();
  if (largest <= 0.0) return MatrixXd(A.rows(), 0);
  const auto kept = (values.array() > invisible * largest).count();
  return scale.asDiagonal() * eigen.eigenvectors().rightCols(kept) *
         values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace magimu
