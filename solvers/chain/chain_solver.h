// SPDX-License-Identifier: BSD-3-Clause
// Cholesky for chains + globals: variables in levels of which each is coupled only to the next (the
// nodes of a recording, one level a node), and a few globals that all share (calibration
// parameters). The levels are found from the graph itself. Elimination level by level, from both
// ends of a chain to its middle, is nothing but small dense products, many times faster than
// general sparse Cholesky. Same bits for every number of threads.
#pragma once

#include <memory>

#include "solvers/linear/linear_solver.h"

namespace magimu {

// Null where the system is not of this form: a level is wider than 40 columns, or there are more
// than 512 global columns.
std::unique_ptr<LinearSolver> make_chain_solver(const LinearSystem& system);

}  // namespace magimu
