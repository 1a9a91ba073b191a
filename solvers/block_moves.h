// SPDX-License-Identifier: BSD-3-Clause
// What a robust covariance (sandwich.h) is made of: by how much each block of rows moves the
// variables, L u_b, one column a block. An estimate from several data sets has the blocks of all of
// them. Fewer than two blocks have no scatter, and columns whose squares are A^-1 stand for it.
#pragma once

#include "solvers/sandwich.h"

namespace magimu {

// As those without `moved`.
MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const MatrixXd& covariance, const std::vector<int>& block_of_row,
                             int blocks, MatrixXd& moved);
MatrixXd sandwich_covariance(const MatrixXd& covariance, const std::vector<BlockScore>& blocks,
                             MatrixXd& moved);

// The robust covariance of variables that blocks move so; covariance: under white noise.
MatrixXd sandwich_of_moves(const MatrixXd& covariance, const MatrixXd& moved);

}  // namespace magimu
