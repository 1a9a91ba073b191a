// SPDX-License-Identifier: BSD-3-Clause
#include "graph/decompositions.h"

namespace Eigen {

template class JacobiSVD<magimu::MatrixXd>;
template class SelfAdjointEigenSolver<magimu::MatrixXd>;
template SelfAdjointEigenSolver<magimu::MatrixXd>&
SelfAdjointEigenSolver<magimu::MatrixXd>::compute(const EigenBase<magimu::MatrixXd>&, int);

}  // namespace Eigen
