// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/eigen_solver.h"

#include <Eigen/SparseCholesky>

namespace magimu {
namespace {

using RowSparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using ColSparse = Eigen::SparseMatrix<double, Eigen::ColMajor>;

class EigenSolver final : public LinearSolver {
 public:
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(system.value().size());
    for (int i = 0; i < system.rows(); ++i) {
      for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
           ++e) {
        const int c = system.column()[std::size_t(e)];
        entries.emplace_back(i, c, system.value()[std::size_t(e)] * scale[c]);
      }
    }
    RowSparse J(system.rows(), system.cols());
    J.setFromTriplets(entries.begin(), entries.end());
    ColSparse H = (J.transpose() * J).pruned(0.0, 0.0);
    ColSparse damping(system.cols(), system.cols());
    damping.setIdentity();
    H += damping * lambda;
    llt_.compute(H);
    if (llt_.info() != Eigen::Success) return false;
    // Rounding lets a singular matrix pass with a pivot of some 1e-16; columns have unit norm.
    const ColSparse L = llt_.matrixL();
    return L.diagonal().minCoeff() > 1e-7 * std::max(1.0, L.diagonal().maxCoeff());
  }

  VectorXd solve(const LinearSystem& system, const VectorXd& scale) override {
    const VectorXd rhs = -scale.cwiseProduct(system.gradient());
    return llt_.solve(rhs);
  }

  MatrixXd solve_normal(const MatrixXd& B) override { return llt_.solve(B); }

 private:
  Eigen::SimplicialLLT<ColSparse> llt_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_eigen_solver() { return std::make_unique<EigenSolver>(); }

}  // namespace magimu
