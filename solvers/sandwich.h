// SPDX-License-Identifier: BSD-3-Clause
// A covariance that stays honest where the residuals are not white: V = A^-1 (sum_b s_b s_b') A^-1
// with A the information of some variables (all others eliminated) and s_b the sum of the efficient
// score over one block of rows. Blocks must outlast the residuals' correlation. Needs many more
// blocks than variables; the usual factor n / (n - 1) is applied.
#pragma once

#include <vector>

#include "graph/linear_system.h"

namespace magimu {

// H_columns: the columns of (J'J)^-1 that belong to the variables, all rows (cols() x p).
// block_of_row: which block each row belongs to, 0 <= b < blocks.
MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const std::vector<int>& block_of_row, int blocks);

}  // namespace magimu
