// SPDX-License-Identifier: BSD-3-Clause
// Orthogonal triangularization of small dense blocks of rows, the step that everything in
// square-root form is made of (condensed_triangle.h, window_elimination.h). Reflections leave alone
// the rows that are zero in the pivot's column, so that stacked triangles cost what their entries
// cost, not what the rectangle around them would.
#pragma once

#include <vector>

#include "graph/scalar.h"

namespace magimu {

// Row by row, so that rows are stacked by copying and a reflection runs along memory.
using RowBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Householder reflections of the rows from `top` on: columns begin <= j < end are zero below their
// pivot afterwards. pivot_row[j - begin] is the row that holds pivot j: top, top + 1, ... in order;
// or -1 where the column was zero already (to 1e-13 of its norm), which uses up no row. Returns
// the first row below the pivots'.
int triangularize(RowBlock& A, int top, int begin, int end, std::vector<int>& pivot_row);

}  // namespace magimu
