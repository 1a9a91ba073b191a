// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/back_ends.h"

#include <stdexcept>

#include "solvers/chain/chain_solver.h"
#include "solvers/sparse/eigen_solver.h"
#ifdef MAGIMU_WITH_SUITESPARSE
#include "solvers/sparse/cholmod_solver.h"
#include "solvers/sparse/spqr_solver.h"
#endif

namespace magimu {

namespace {

std::unique_ptr<LinearSolver> make_general_solver() {
#ifdef MAGIMU_WITH_SUITESPARSE
  return make_cholmod_solver();
#else
  return make_eigen_solver();
#endif
}

// Looks at the system first, then chooses.
class StructuredSolver final : public LinearSolver {
 public:
  explicit StructuredSolver(bool chain_only) : chain_only_(chain_only) {}

  Backend backend() const override {
    return chosen_ == nullptr ? Backend::kAuto : chosen_->backend();
  }
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    if (chosen_ == nullptr) chosen_ = make_chain_solver(system);
    if (chosen_ == nullptr && chain_only_) {
      throw std::invalid_argument(
          "the graph is not made of chains that share a few globals, so the chain back end cannot "
          "serve; use Backend::kAuto");
    }
    if (chosen_ == nullptr) chosen_ = make_general_solver();
    return chosen_->factorize(system, scale, lambda);
  }
  VectorXd solve(const LinearSystem& system, const VectorXd& scale) override {
    return chosen_->solve(system, scale);
  }
  MatrixXd solve_normal(const MatrixXd& B) override { return chosen_->solve_normal(B); }

 private:
  bool chain_only_;
  std::unique_ptr<LinearSolver> chosen_;
};

}  // namespace

Backend square_root_backend() {
#ifdef MAGIMU_WITH_SUITESPARSE
  return Backend::kSpqr;
#else
  return Backend::kEigen;
#endif
}

std::unique_ptr<LinearSolver> make_linear_solver(Backend backend) {
  if (backend == Backend::kWindows) backend = Backend::kAuto;  // the windows' own are optimizers'
  if (backend == Backend::kAuto || backend == Backend::kChain) {
    return std::make_unique<StructuredSolver>(backend == Backend::kChain);
  }
#ifdef MAGIMU_WITH_SUITESPARSE
  if (backend == Backend::kCholmod) return make_cholmod_solver();
  if (backend == Backend::kSpqr) return make_spqr_solver();
#endif
  if (backend == Backend::kEigen) return make_eigen_solver();
  throw std::invalid_argument("magimu was built without SuiteSparse, so there is no " +
                              to_string(backend) +
                              " back end; configure with -DMAGIMU_WITH_SUITESPARSE=ON");
}

}  // namespace magimu
