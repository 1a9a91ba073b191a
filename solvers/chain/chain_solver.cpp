// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/chain/chain_solver.h"

#include <algorithm>
#include <utility>

#include "graph/parallel.h"
#include "solvers/chain/chain_elimination.h"

namespace magimu {
namespace {

using chain::Level;

class ChainSolver final : public LinearSolver {
 public:
  explicit ChainSolver(chain::Structure structure) : u_(std::move(structure)) {}

  Backend backend() const override { return Backend::kChain; }
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    return u_.factorize(system, scale, lambda);
  }

  VectorXd solve(const LinearSystem& system, const VectorXd& scale) override {
    return solve_normal(-scale.cwiseProduct(system.gradient()));
  }

  MatrixXd solve_normal(const MatrixXd& B) override {
    MatrixXd X(B.rows(), B.cols());
    if (B.cols() == 1) {
      solve_columns<1>(B, X, 0);
      return X;
    }
    parallel::for_each(std::size_t((B.cols() + kColumns - 1) / kColumns), [&](std::size_t i) {
      solve_columns<kColumns>(B, X, Eigen::Index(i) * kColumns);
    });
    return X;
  }

 private:
  using RowsOfGlobals = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr int kColumns = 8;  // right-hand sides that are solved for at a time

  // Columns first to first + N of the solution for those of B, as many as there are.
  template <int N>
  void solve_columns(const MatrixXd& B, MatrixXd& X, Eigen::Index first) const {
    using RowsOfN =
        Eigen::Matrix<double, Eigen::Dynamic, N, N == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
    const Eigen::Index count = std::min<Eigen::Index>(N, B.cols() - first);
    RowsOfN x = RowsOfN::Zero(B.rows(), N);
    bool on_chain = false;  // not where the globals' covariance is asked for
    for (Eigen::Index c = 0; c < B.rows(); ++c) {
      const int position = structure().position[std::size_t(c)];
      for (Eigen::Index k = 0; k < count; ++k) {
        x(position, k) = B(c, first + k);
        on_chain |= position < structure().chain && x(position, k) != 0.0;
      }
    }
    const int chain = structure().chain, g = structure().globals;
    Level center;
    center.first = chain;
    center.width = g;
    // What chain and globals take from each other, in two large products.
    const Eigen::Map<const RowsOfGlobals> border(u_.border(), chain, g);
    if (on_chain) {
      for (const Level& level : structure().levels) forward(level, u_.panel(level), x);
      x.bottomRows(g).noalias() -= border.transpose() * x.topRows(chain);
    }
    forward(center, u_.center(), x);
    backward(center, u_.center(), x);
    x.topRows(chain).noalias() -= border * x.bottomRows(g);
    for (std::size_t l = structure().levels.size(); l-- > 0;) {
      const Level& level = structure().levels[l];
      backward(level, u_.panel(level), x);
    }
    for (Eigen::Index c = 0; c < B.rows(); ++c) {
      for (Eigen::Index k = 0; k < count; ++k)
        X(c, first + k) = x(structure().position[std::size_t(c)], k);
    }
  }
  int parent_first(const Level& level) const {
    return level.parent < 0 ? 0 : structure().levels[std::size_t(level.parent)].first;
  }

  template <class M>
  void forward(const Level& level, const double* row, M& x) const {
    const int d = level.width, n = level.parent_width, parent = parent_first(level);
    const double* inverse_diagonal = u_.inverse_diagonal() + level.first;
    for (int i = 0; i < d; ++i, row += d + n) {
      x.row(level.first + i) *= inverse_diagonal[i];
      const auto xi = x.row(level.first + i).eval();
      for (int k = i + 1; k < d; ++k) x.row(level.first + k) -= row[k] * xi;
      for (int k = 0; k < n; ++k) x.row(parent + k) -= row[d + k] * xi;
    }
  }
  template <class M>
  void backward(const Level& level, const double* panel, M& x) const {
    const int d = level.width, n = level.parent_width, parent = parent_first(level);
    const double* inverse_diagonal = u_.inverse_diagonal() + level.first;
    for (int i = d - 1; i >= 0; --i) {
      const double* const row = panel + i * (d + n);
      auto xi = x.row(level.first + i).eval();
      for (int k = i + 1; k < d; ++k) xi -= row[k] * x.row(level.first + k);
      for (int k = 0; k < n; ++k) xi -= row[d + k] * x.row(parent + k);
      x.row(level.first + i) = xi * inverse_diagonal[i];
    }
  }

  const chain::Structure& structure() const { return u_.structure(); }

  chain::Elimination u_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_chain_solver(const LinearSystem& system) {
  std::optional<chain::Structure> structure = chain::find_structure(system);
  if (!structure) return nullptr;
  return std::make_unique<ChainSolver>(std::move(*structure));
}

}  // namespace magimu
