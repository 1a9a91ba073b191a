// SPDX-License-Identifier: BSD-3-Clause
// The Jacobian of a linearized graph as a dense matrix, to compare with dense linear algebra.
#pragma once

#include "graph/linear_system.h"

namespace magimu::test {

inline MatrixXd dense_jacobian(const LinearSystem& system) {
  MatrixXd J = MatrixXd::Zero(system.rows(), system.cols());
  for (int i = 0; i < system.rows(); ++i) {
    for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
         ++e) {
      J(i, system.column()[std::size_t(e)]) += system.value()[std::size_t(e)];
    }
  }
  return J;
}

}  // namespace magimu::test
