// SPDX-License-Identifier: BSD-3-Clause
// The linear solvers that there are (linear/linear_solver.h), by name.
#pragma once

#include <memory>

#include "solvers/linear/linear_solver.h"

namespace magimu {

// A new solver, owned by the caller. Throws std::invalid_argument if the back end was not built in.
// With kAuto and kChain the structure is found at the first factorize(); for kChain that call
// throws std::invalid_argument if the system is not of its form.
std::unique_ptr<LinearSolver> make_linear_solver(Backend backend);

// The back end for problems close to singular: orthogonal transformations of J itself (SPQR).
// Without SuiteSparse, the most careful one that was built in.
Backend square_root_backend();

}  // namespace magimu
