// SPDX-License-Identifier: BSD-3-Clause
// The SPQR back end: multifrontal orthogonal factorization of [J S; sqrt(lambda) I].
#pragma once

#include "solvers/linear/linear_solver.h"

namespace magimu {

std::unique_ptr<LinearSolver> make_spqr_solver();

}  // namespace magimu
