// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/damped_factor.h"

#include "graph/checks/not_finite.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr double kLeastDamping = 1e-12, kLargestDamping = 1.0;

// Negative where none helps.
double least_damping(LinearSolver& solver, const LinearSystem& system, const VectorXd& scale) {
  if (!is_finite(system)) return -1.0;
  if (solver.factorize(system, scale, 0.0)) return 0.0;
  for (double damping = kLeastDamping; damping < 3.0 * kLargestDamping; damping *= 10.0) {
    if (solver.factorize(system, scale, damping)) return damping;
  }
  return -1.0;
}

}  // namespace

bool is_finite(const LinearSystem& system) {
  return system.residual().allFinite() && system.squared_column_norms().allFinite();
}

double factorize_damped(LinearSolver& solver, const LinearSystem& system, const VectorXd& scale) {
  const double damping = least_damping(solver, system, scale);
  if (damping >= 0.0) return damping;
  throw NumericalError("the linear system has numbers that are not finite, or too large for it");
}

double factorize_damped(LinearSolver& solver, const LinearSystem& system, const VectorXd& scale,
                        const FactorGraph& graph, const Values& values) {
  const double damping = least_damping(solver, system, scale);
  if (damping >= 0.0) return damping;
  const std::optional<NotFinite> found = find_not_finite(graph, values);
  throw NumericalError(found ? found->what + " is not a finite number"
                             : "the linear system has numbers that are too large to be solved");
}

}  // namespace magimu
