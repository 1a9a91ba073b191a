// SPDX-License-Identifier: BSD-3-Clause
// The linear solvers that there are (linear/linear_solver.h), by name.
#pragma once

#include <memory>

#include "solvers/linear/linear_solver.h"

namespace magimu {

// Throws std::invalid_argument if the back end was not built in. With kAuto and kChain the first
// factorize() looks at the system; kChain's throws std::invalid_argument if it has no such form.
std::unique_ptr<LinearSolver> make_linear_solver(Backend backend);

// The one that works on J itself by orthogonal transformations, for problems close to singular;
// the most careful that there is where SuiteSparse is not built in.
Backend square_root_backend();

}  // namespace magimu
