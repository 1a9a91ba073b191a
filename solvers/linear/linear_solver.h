// SPDX-License-Identifier: BSD-3-Clause
// The linear problem inside every step: minimize |J S y + r|^2 + lambda |y|^2 over y, where S
// scales the columns (delta = S y). One interface, several back ends; all give the same answer.
#pragma once

#include <memory>
#include <string>

#include "graph/linear_system.h"

namespace magimu {

enum class Backend {
  kAuto,     // windows where the graph fits, or the chain solver; else CHOLMOD, or Eigen
  kWindows,  // optimizers only: chains that share a few globals, linearized and eliminated in one
             // pass in SIMD lanes; in square-root form once they come close to singular
  kChain,    // block elimination along chains that share a few globals: many times faster
  kCholmod,  // supernodal Cholesky of J'J: fast; squares the condition number
  kSpqr,     // multifrontal QR of J: for problems close to singular
  kEigen,    // Eigen's simplicial Cholesky: no GPL code
};

std::string to_string(Backend backend);

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Which one it is; of one that chooses by the system's structure, kAuto before it has chosen.
  virtual Backend backend() const = 0;
  // Factorizes with the system's present numbers; the structure is analysed at the first call and
  // must not change afterwards. False if the matrix is singular to working precision.
  virtual bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) = 0;
  // The minimizing y, after a successful factorize().
  virtual VectorXd solve(const LinearSystem& system, const VectorXd& scale) = 0;
  // (S J'J S + lambda I)^-1 B.
  virtual MatrixXd solve_normal(const MatrixXd& B) = 0;
};

// 1 / norm of each column of J; 1 where the column is zero.
VectorXd column_scale(const LinearSystem& system);

}  // namespace magimu
