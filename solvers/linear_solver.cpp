// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/linear_solver.h"

#include "solvers/eigen_solver.h"
#ifdef MAGIMU_WITH_SUITESPARSE
#include "solvers/cholmod_solver.h"
#include "solvers/spqr_solver.h"
#endif

namespace magimu {

std::string to_string(Backend backend) {
  switch (backend) {
    case Backend::kAuto:
      return "auto";
    case Backend::kCholmod:
      return "CHOLMOD";
    case Backend::kSpqr:
      return "SPQR";
    case Backend::kEigen:
      return "Eigen";
  }
  return "?";
}

std::unique_ptr<LinearSolver> make_linear_solver(Backend backend) {
#ifdef MAGIMU_WITH_SUITESPARSE
  if (backend == Backend::kAuto || backend == Backend::kCholmod) return make_cholmod_solver();
  if (backend == Backend::kSpqr) return make_spqr_solver();
#endif
  if (backend == Backend::kAuto || backend == Backend::kEigen) return make_eigen_solver();
  throw std::invalid_argument("magimu was built without SuiteSparse, so there is no " +
                              to_string(backend) +
                              " back end; configure with -DMAGIMU_WITH_SUITESPARSE=ON");
}

VectorXd column_scale(const LinearSystem& system) {
  VectorXd norms = system.squared_column_norms();
  return norms.unaryExpr([](double n2) { return n2 > 0.0 ? 1.0 / std::sqrt(n2) : 1.0; });
}

}  // namespace magimu
