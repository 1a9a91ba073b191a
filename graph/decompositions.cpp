// SPDX-License-Identifier: BSD-3-Clause
#include "graph/decompositions.h"

namespace Eigen {

MAGIMU_DECOMPOSITIONS(template);

}  // namespace Eigen

namespace magimu {

Matrix3 nearest_orthogonal(const Matrix3& M) {
  const Eigen::JacobiSVD<MatrixXd> svd(MatrixXd(M), Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace magimu
