// SPDX-License-Identifier: BSD-3-Clause
// The back end without SuiteSparse: Eigen's simplicial Cholesky of the normal equations.
#pragma once

#include "solvers/linear/linear_solver.h"

namespace magimu {

std::unique_ptr<LinearSolver> make_eigen_solver();

}  // namespace magimu
