// SPDX-License-Identifier: BSD-3-Clause
// Decompositions of Eigen's that several files use and that take compilers long: compiled once, in
// decompositions.cpp. Of a MatrixXd, that is, and their solutions for a MatrixXd or a VectorXd; of
// expressions, where they are used.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "graph/scalar.h"

// Says `linkage` of everything that is compiled once.
// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are words and types.
#define MAGIMU_SOLVED_FOR(linkage, Decomposition, Right)                                        \
  linkage void Decomposition<magimu::MatrixXd>::_solve_impl<Right, Right>(const Right&, Right&) \
      const;                                                                                    \
  linkage void Decomposition<magimu::MatrixXd>::_solve_impl_transposed<true, Right, Right>(     \
      const Right&, Right&) const
#define MAGIMU_COMPUTED(linkage, Decomposition, ...)                                 \
  linkage class Decomposition<magimu::MatrixXd>;                                     \
  linkage Decomposition<magimu::MatrixXd>& Decomposition<magimu::MatrixXd>::compute( \
      const EigenBase<magimu::MatrixXd>& __VA_OPT__(, ) __VA_ARGS__)
#define MAGIMU_SOLVING(linkage, Decomposition)                 \
  MAGIMU_COMPUTED(linkage, Decomposition);                     \
  MAGIMU_SOLVED_FOR(linkage, Decomposition, magimu::MatrixXd); \
  MAGIMU_SOLVED_FOR(linkage, Decomposition, magimu::VectorXd)
#define MAGIMU_DECOMPOSITIONS(linkage)                   \
  linkage class JacobiSVD<magimu::MatrixXd>;             \
  MAGIMU_COMPUTED(linkage, SelfAdjointEigenSolver, int); \
  MAGIMU_SOLVING(linkage, LDLT);                         \
  MAGIMU_SOLVING(linkage, LLT);                          \
  MAGIMU_SOLVING(linkage, ColPivHouseholderQR)
// NOLINTEND(bugprone-macro-parentheses)

namespace Eigen {

MAGIMU_DECOMPOSITIONS(extern template);

}  // namespace Eigen

namespace magimu {

// Q of the polar decomposition M = Q P: the nearest orthogonal matrix in the Frobenius norm, a
// reflection where det M < 0.
Matrix3 nearest_orthogonal(const Matrix3& M);

}  // namespace magimu
