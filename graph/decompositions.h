// SPDX-License-Identifier: BSD-3-Clause
// Decompositions of Eigen's that several files use and that take compilers long: compiled once, in
// decompositions.cpp. Of a MatrixXd, that is; of an expression, where it is used.
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "graph/scalar.h"

namespace Eigen {

extern template class JacobiSVD<magimu::MatrixXd>;
extern template class SelfAdjointEigenSolver<magimu::MatrixXd>;
extern template SelfAdjointEigenSolver<magimu::MatrixXd>&
SelfAdjointEigenSolver<magimu::MatrixXd>::compute(const EigenBase<magimu::MatrixXd>&, int);

}  // namespace Eigen
