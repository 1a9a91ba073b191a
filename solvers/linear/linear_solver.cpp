// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/linear/linear_solver.h"

#include <cmath>

namespace magimu {

std::string to_string(Backend backend) {
  switch (backend) {
    case Backend::kAuto:
      return "auto";
    case Backend::kWindows:
      return "windows";
    case Backend::kChain:
      return "chain";
    case Backend::kCholmod:
      return "CHOLMOD";
    case Backend::kSpqr:
      return "SPQR";
    case Backend::kEigen:
      return "Eigen";
  }
  return "?";
}

VectorXd column_scale(const LinearSystem& system) {
  VectorXd norms = system.squared_column_norms();
  return norms.unaryExpr([](double n2) { return n2 > 0.0 ? 1.0 / std::sqrt(n2) : 1.0; });
}

}  // namespace magimu
