// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/sandwich.h"

namespace magimu {

MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const std::vector<int>& block_of_row, int blocks) {
  // J H_columns = (J_theta - J_x L_xx^-1 L_x,theta) A^-1: each row's influence on the estimate.
  const Eigen::Index p = H_columns.cols();
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> H = H_columns;
  MatrixXd scores = MatrixXd::Zero(p, blocks);
  for (int i = 0; i < system.rows(); ++i) {
    auto score = scores.col(block_of_row[std::size_t(i)]);
    const double r = system.residual()[i];
    for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
         ++e) {
      score +=
          (r * system.value()[std::size_t(e)]) * H.row(system.column()[std::size_t(e)]).transpose();
    }
  }
  const double correction = blocks > 1 ? double(blocks) / (blocks - 1) : 1.0;
  return correction * scores * scores.transpose();
}

}  // namespace magimu
