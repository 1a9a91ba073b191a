// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/sparse/eigen_solver.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <numeric>

namespace magimu {
namespace {

using RowSparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using ColSparse = Eigen::SparseMatrix<double, Eigen::ColMajor>;

class EigenSolver final : public LinearSolver {
 public:
  Backend backend() const override { return Backend::kEigen; }
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    const bool first = position_.empty();
    if (first) analyse(system);
    double* value = jacobian_.valuePtr();
    for (std::size_t e = 0; e < position_.size(); ++e) {
      value[position_[e]] = system.value()[e] * scale[system.column()[e]];
    }
    // No column is empty, so the diagonal is there; entries that happen to be zero stay.
    ColSparse H = jacobian_.transpose() * jacobian_;
    H.diagonal().array() += lambda;
    if (first) llt_.analyzePattern(H);
    llt_.factorize(H);
    if (llt_.info() != Eigen::Success) return false;
    // Rounding lets a singular matrix pass with a pivot of some 1e-16; columns have unit norm.
    const VectorXd d = llt_.matrixL().nestedExpression().diagonal();
    return d.minCoeff() > 1e-7 * std::max(1.0, d.maxCoeff());
  }

  VectorXd solve(const LinearSystem& system, const VectorXd& scale) override {
    const VectorXd rhs = -scale.cwiseProduct(system.gradient());
    return llt_.solve(rhs);
  }

  MatrixXd solve_normal(const MatrixXd& B) override { return llt_.solve(B); }

 private:
  // The Jacobian's structure with the columns of each row in order; position_ maps its entries.
  void analyse(const LinearSystem& system) {
    const auto start = system.row_start();
    const auto column = system.column();
    std::vector<int> order(column.size());
    std::iota(order.begin(), order.end(), 0);
    position_.resize(column.size());
    jacobian_.resize(system.rows(), system.cols());
    jacobian_.resizeNonZeros(Eigen::Index(column.size()));
    std::copy(start.begin(), start.end(), jacobian_.outerIndexPtr());
    for (std::size_t row = 0; row + 1 < start.size(); ++row) {
      std::sort(order.begin() + start[row], order.begin() + start[row + 1],
                [&](int a, int b) { return column[std::size_t(a)] < column[std::size_t(b)]; });
    }
    for (std::size_t p = 0; p < order.size(); ++p) {
      position_[std::size_t(order[p])] = int(p);
      jacobian_.innerIndexPtr()[p] = column[std::size_t(order[p])];
    }
  }

  RowSparse jacobian_;
  std::vector<int> position_;  // of the system's entries in it
  Eigen::SimplicialLLT<ColSparse> llt_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_eigen_solver() { return std::make_unique<EigenSolver>(); }

}  // namespace magimu
