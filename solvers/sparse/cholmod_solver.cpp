// SPDX-License-Identifier: BSD-3-Clause
#ifdef MAGIMU_WITH_SUITESPARSE
#include "solvers/sparse/cholmod_solver.h"

#include <optional>

#include "solvers/sparse/cholmod_handles.h"

namespace magimu {
namespace {

class CholmodSolver final : public LinearSolver {
 public:
  CholmodSolver() {
    common_.get()->final_ll = 1;
    common_.get()->nmethods = 1;
    common_.get()->method[0].ordering = CHOLMOD_GIVEN;
    common_.get()->postorder = 1;
  }
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;
  ~CholmodSolver() override { cholmod_l_free_factor(&factor_, common_.get()); }

  Backend backend() const override { return Backend::kCholmod; }
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    const std::lock_guard lock(one_at_a_time);
    if (factor_ == nullptr) {
      jacobian_.emplace(system);
      std::vector<SuiteSparse_long> order = jacobian_->order_globals_last(common_);
      cholmod_sparse A = jacobian_->matrix();
      factor_ = cholmod_l_analyze_p(&A, order.data(), nullptr, 0, common_.get());
      if (factor_ == nullptr) throw std::runtime_error("CHOLMOD could not analyse: out of memory");
    }
    for (std::size_t e = 0; e < system.value().size(); ++e) {
      jacobian_->value()[e] = system.value()[e] * scale[system.column()[e]];
    }
    cholmod_sparse A = jacobian_->matrix();
    double beta[2] = {lambda, 0.0};
    cholmod_l_factorize_p(&A, beta, nullptr, 0, factor_, common_.get());
    if (common_.get()->status != CHOLMOD_OK) return false;
    // rcond is the squared ratio of the extreme diagonal entries; columns have unit norm. Rounding
    // alone lets a singular matrix pass with about 1e-16.
    return cholmod_l_rcond(factor_, common_.get()) > 1e-14;
  }

  VectorXd solve(const LinearSystem& system, const VectorXd& scale) override {
    return solve_normal(-scale.cwiseProduct(system.gradient()));
  }

  MatrixXd solve_normal(const MatrixXd& B) override {
    const std::lock_guard lock(one_at_a_time);
    MatrixXd copy = B;
    cholmod_dense b = view(copy);
    cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, factor_, &b, common_.get());
    if (x == nullptr) throw std::runtime_error("CHOLMOD could not solve: out of memory");
    MatrixXd out = Eigen::Map<const MatrixXd>(static_cast<const double*>(x->x), B.rows(), B.cols());
    cholmod_l_free_dense(&x, common_.get());
    return out;
  }

 private:
  CholmodCommon common_;
  cholmod_factor* factor_ = nullptr;
  std::optional<TransposedJacobian> jacobian_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_cholmod_solver() { return std::make_unique<CholmodSolver>(); }

}  // namespace magimu
#endif
