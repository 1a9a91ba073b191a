// SPDX-License-Identifier: BSD-3-Clause
// The CHOLMOD back end: supernodal Cholesky of S J'J S + lambda I.
#pragma once

#include "solvers/linear/linear_solver.h"

namespace magimu {

std::unique_ptr<LinearSolver> make_cholmod_solver();

}  // namespace magimu
