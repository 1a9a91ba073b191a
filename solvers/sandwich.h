// SPDX-License-Identifier: BSD-3-Clause
// A covariance that stays honest where the residuals are not white. With A the information of some
// variables (all others eliminated) and s_b the sum of the efficient score over one block of rows,
//
//   V = A^-1 (sum_b s_b s_b') A^-1
//
// Blocks must outlast the residuals' correlation. There are few of them, so that, in coordinates
// where A is the identity:
//
//   u_b = (I - Q_b)^-1/2 L' s_b     with A^-1 = L L' and Q_b block b's share of the information
//                                   (sum_b Q_b = I): the fit has followed a block by that much
//                                   (Bell and McCaffrey 2002)
//   S   = (1 - lambda) sum_b u_b u_b' + lambda mu I,   mu the mean of the sum's diagonal
//                                   lambda as far as the blocks' scatter leaves the sum uncertain
//                                   (Ledoit and Wolf 2004)
//
// and V = L S L' (n - 1) / (n - 3), the variance of Student's distribution for n blocks, in no
// direction less than A^-1: definite however few blocks there are, and never surer than white noise
// would be. White noise of the right size gives A^-1 and a few percent.
#pragma once

#include <vector>

#include "graph/linear_system.h"

namespace magimu {

// H_columns: the columns of (J'J)^-1 that belong to the variables, all rows (cols() x p).
// covariance: those variables' block of it, A^-1; directions in which it is singular stay so.
// block_of_row: which block each row belongs to, 0 <= b < blocks; negative: none (a prior).
MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const MatrixXd& covariance, const std::vector<int>& block_of_row,
                             int blocks);

// What one block says of some variables: its efficient score and its share of their information.
struct BlockScore {
  VectorXd score;
  MatrixXd information;
};
// The same of blocks whose scores are known. covariance: of the same variables.
MatrixXd sandwich_covariance(const MatrixXd& covariance, const std::vector<BlockScore>& blocks);

// (n - 1) / (n - 3) of so many blocks; 3 of four and fewer.
double student_variance(int blocks);

}  // namespace magimu
