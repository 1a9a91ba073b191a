// SPDX-License-Identifier: BSD-3-Clause
#ifdef MAGIMU_WITH_SUITESPARSE
#include "solvers/sparse/spqr_solver.h"

#include <SuiteSparseQR.hpp>

#include "solvers/sparse/cholmod_handles.h"

namespace magimu {
namespace {

// Columns of J S have norm 1 at most: a pivot below this is zero up to rounding.
constexpr double kRankTolerance = 1e-10;

class SpqrSolver final : public LinearSolver {
 public:
  SpqrSolver() = default;
  SpqrSolver(const SpqrSolver&) = delete;
  SpqrSolver& operator=(const SpqrSolver&) = delete;
  ~SpqrSolver() override { SuiteSparseQR_free<double>(&qr_, common_.get()); }

  Backend backend() const override { return Backend::kSpqr; }
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    const std::lock_guard lock(one_at_a_time);
    const bool damped = lambda > 0.0;
    if (order_.empty()) order_ = TransposedJacobian(system).order_globals_last(common_);
    if (qr_ == nullptr || damped != damped_) analyse(system, damped);
    cholmod_sparse A = matrix();
    for (std::size_t e = 0; e < system.value().size(); ++e) {
      value_[std::size_t(position_[e])] = system.value()[e] * scale[system.column()[e]];
    }
    if (damped) {
      for (int c = 0; c < system.cols(); ++c) {
        value_[std::size_t(start_[std::size_t(c) + 1]) - 1] = std::sqrt(lambda);
      }
    }
    SuiteSparseQR_numeric<double>(kRankTolerance, &A, qr_, common_.get());
    return common_.get()->status >= CHOLMOD_OK && qr_->rank == system.cols();
  }

  VectorXd solve(const LinearSystem& system, const VectorXd&) override {
    const std::lock_guard lock(one_at_a_time);
    MatrixXd b = MatrixXd::Zero(rows_, 1);
    b.col(0).head(system.rows()) = -system.residual();
    cholmod_dense view_b = view(b);
    cholmod_dense* qtb = SuiteSparseQR_qmult<double>(SPQR_QTX, qr_, &view_b, common_.get());
    const MatrixXd y = triangular_solve(SPQR_RETX_EQUALS_B, qtb);
    cholmod_l_free_dense(&qtb, common_.get());
    return from_ordered(y);
  }

  MatrixXd solve_normal(const MatrixXd& B) override {
    const std::lock_guard lock(one_at_a_time);
    MatrixXd ordered(B.rows(), B.cols());
    for (int k = 0; k < B.rows(); ++k) ordered.row(k) = B.row(order_[std::size_t(k)]);
    cholmod_dense b = view(ordered);
    cholmod_dense* half = SuiteSparseQR_solve<double>(SPQR_RTX_EQUALS_ETB, qr_, &b, common_.get());
    const MatrixXd x = triangular_solve(SPQR_RETX_EQUALS_B, half);
    cholmod_l_free_dense(&half, common_.get());
    return from_ordered(x);
  }

 private:
  MatrixXd triangular_solve(int kind, cholmod_dense* b) {
    if (b == nullptr) throw std::runtime_error("SPQR could not solve: out of memory");
    cholmod_dense* x = SuiteSparseQR_solve<double>(kind, qr_, b, common_.get());
    if (x == nullptr) throw std::runtime_error("SPQR could not solve: out of memory");
    MatrixXd out = Eigen::Map<const MatrixXd>(static_cast<const double*>(x->x),
                                              Eigen::Index(x->nrow), Eigen::Index(x->ncol));
    cholmod_l_free_dense(&x, common_.get());
    return out;
  }

  MatrixXd from_ordered(const MatrixXd& y) const {
    MatrixXd out(y.rows(), y.cols());
    for (int k = 0; k < y.rows(); ++k) out.row(order_[std::size_t(k)]) = y.row(k);
    return out;
  }

  // The structure of the ordered columns of [J; sqrt(lambda) I]; position_ maps J's entries there.
  void analyse(const LinearSystem& system, bool damped) {
    const int n = system.cols();
    std::vector<SuiteSparse_long> place(order_.size());
    for (int k = 0; k < n; ++k) place[std::size_t(order_[std::size_t(k)])] = k;
    start_.assign(std::size_t(n) + 1, 0);
    for (const int c : system.column()) ++start_[std::size_t(place[std::size_t(c)]) + 1];
    for (int k = 0; k < n; ++k) {
      start_[std::size_t(k) + 1] += start_[std::size_t(k)] + (damped ? 1 : 0);
    }
    row_.resize(std::size_t(start_.back()));
    value_.resize(row_.size());
    position_.resize(system.column().size());
    std::vector<SuiteSparse_long> next(start_.begin(), start_.end() - 1);
    for (int i = 0; i < system.rows(); ++i) {
      for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
           ++e) {
        const auto k = std::size_t(place[std::size_t(system.column()[std::size_t(e)])]);
        position_[std::size_t(e)] = next[k];
        row_[std::size_t(next[k]++)] = i;
      }
    }
    if (damped) {
      for (int k = 0; k < n; ++k) row_[std::size_t(next[std::size_t(k)])] = system.rows() + k;
    }
    damped_ = damped;
    rows_ = system.rows() + (damped ? n : 0);
    SuiteSparseQR_free<double>(&qr_, common_.get());
    cholmod_sparse A = matrix();
    qr_ = SuiteSparseQR_symbolic<double>(SPQR_ORDERING_FIXED, 1, &A, common_.get());
    if (qr_ == nullptr) throw std::runtime_error("SPQR could not analyse: out of memory");
  }

  cholmod_sparse matrix() { return view(std::size_t(rows_), start_, row_, value_, true); }

  CholmodCommon common_;
  SuiteSparseQR_factorization<double>* qr_ = nullptr;
  bool damped_ = false;
  int rows_ = 0;
  std::vector<SuiteSparse_long> order_, start_, row_, position_;
  std::vector<double> value_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_spqr_solver() { return std::make_unique<SpqrSolver>(); }

}  // namespace magimu
#endif
