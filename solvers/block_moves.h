// SPDX-License-Identifier: BSD-3-Clause
// The moves that a robust covariance is made of: L u_b of sandwich.h, by how much block b of rows
// moves the variables, one column a block. An estimate from several data sets has the blocks of all
// of them. Fewer than two blocks have no scatter: the columns of L, with L L' = A^-1, stand for it.
#pragma once

#include "solvers/sandwich.h"

namespace magimu {

// As sandwich_covariance() without `moved` (sandwich.h). moved: a row a variable, a column a block.
MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const MatrixXd& covariance, const std::vector<int>& block_of_row,
                             int blocks, MatrixXd& moved);
MatrixXd sandwich_covariance(const MatrixXd& covariance, const std::vector<BlockScore>& blocks,
                             MatrixXd& moved);

// The robust covariance of variables that blocks move by the columns of `moved`. covariance: A^-1,
// theirs under white noise.
MatrixXd sandwich_of_moves(const MatrixXd& covariance, const MatrixXd& moved);

}  // namespace magimu
