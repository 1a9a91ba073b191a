// SPDX-License-Identifier: BSD-3-Clause
// A factorization that also works where the system leaves directions free: with as little damping
// as possible, and with an error where no damping helps.
#pragma once

#include "solvers/linear/linear_solver.h"

namespace magimu {

// Whether residuals, Jacobian and the squared norms of its columns are finite. (Some back ends
// accept numbers that are not.)
bool is_finite(const LinearSystem& system);

// Factorizes undamped, or with the first damping of 1e-12, 1e-11, ..., 1 that makes the matrix
// regular, and returns it. Columns have unit norm, so that a damping of 1 doubles the diagonal: a
// matrix that is still singular has numbers that are not finite. Throws NumericalError then; with
// graph and values, it names the factor.
double factorize_damped(LinearSolver& solver, const LinearSystem& system, const VectorXd& scale);
double factorize_damped(LinearSolver& solver, const LinearSystem& system, const VectorXd& scale,
                        const FactorGraph& graph, const Values& values);

}  // namespace magimu
