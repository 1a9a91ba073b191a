// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/sandwich.h"

#include <algorithm>
#include <cmath>

#include "graph/decompositions.h"
#include "graph/parallel.h"
#include "solvers/block_moves.h"
#include "solvers/kernels/square_sum.h"

namespace magimu {
namespace {

constexpr double kSingular = 1e-12;         // of the largest eigenvalue, variables scaled alike
constexpr Eigen::Index kWideSandwich = 64;  // variables: more cost less by products than by
                                            // eigenvalues
constexpr double kMaxLeverage =
    0.9;  // a block that determines a direction by itself has no scatter

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// L with A^-1 = L L', and its left inverse, on the space where A^-1 is regular.
struct Root {
  MatrixXd L, inverse;
};

Root root_of(const MatrixXd& covariance) {
  const VectorXd sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd scale = sigma.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const MatrixXd scaled = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  const VectorXd& values = eigen.eigenvalues();
  const auto kept = (values.array() > kSingular * values.maxCoeff()).count();  // the last ones
  const VectorXd root = values.tail(kept).cwiseSqrt();
  const MatrixXd U = eigen.eigenvectors().rightCols(kept);
  return {sigma.asDiagonal() * U * root.asDiagonal(),
          root.cwiseInverse().asDiagonal() * U.transpose() * scale.asDiagonal()};
}

// Per block: the sum of its rows' influence times residual, and its share of the information.
struct BlockSums {
  MatrixXd score;                  // one column a block
  std::vector<MatrixXd> leverage;  // Q_b
};

// The rows of each block.
std::vector<std::vector<int>> rows_of_blocks(const std::vector<int>& block_of_row, int blocks) {
  std::vector<std::vector<int>> out{std::size_t(blocks)};
  for (std::size_t i = 0; i < block_of_row.size(); ++i) {
    if (block_of_row[i] >= 0) out[std::size_t(block_of_row[i])].push_back(int(i));
  }
  return out;
}

// H: whitened.
BlockSums sums_of(const LinearSystem& system, const RowMajor& H,
                  const std::vector<int>& block_of_row, int blocks) {
  const int p = int(H.cols());
  const std::vector<std::vector<int>> rows = rows_of_blocks(block_of_row, blocks);
  BlockSums out{MatrixXd::Zero(p, blocks), std::vector<MatrixXd>(std::size_t(blocks))};
  parallel::for_each(rows.size(), [&](std::size_t b) {
    SquareSum sum(p + 1);  // of rows [influence | residual]
    for (const int i : rows[b]) {
      double* const influence = sum.rows(1);
      for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
           ++e) {
        const double x = system.value()[std::size_t(e)];
        if (x == 0.0) continue;  // many are
        const double* const h = H.data() + std::ptrdiff_t(system.column()[std::size_t(e)]) * p;
        for (int k = 0; k < p; ++k) influence[k] += x * h[k];
      }
      influence[p] = system.residual()[i];
    }
    sum.finish();
    MatrixXd& Q = out.leverage[b];
    Q.resize(p, p);
    for (int i = 0; i < p; ++i) {
      for (int j = i; j < p; ++j) Q(i, j) = Q(j, i) = sum(i, j);
      out.score(i, Eigen::Index(b)) = sum(i, p);
    }
  });
  return out;
}

// (I - Q)^-1/2.
MatrixXd adjustment(const MatrixXd& leverage) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(leverage);
  const VectorXd root = eigen.eigenvalues().unaryExpr(
      [](double q) { return 1.0 / std::sqrt(1.0 - std::clamp(q, 0.0, kMaxLeverage)); });
  return eigen.eigenvectors() * root.asDiagonal() * eigen.eigenvectors().transpose();
}

// (I - Q)^-1/2 v by Lanczos' recurrence, of a Q that is known by its products: of many variables a
// block of seconds is a small share of what is known, Q is near zero, and a few products are as
// good as all eigenvalues.
template <class Product>
VectorXd adjusted(const Product& Q, const VectorXd& v) {
  constexpr Eigen::Index kProducts = 30;
  const double length = v.norm();
  const Eigen::Index most = std::min(kProducts, v.size());
  if (length == 0.0 || most == 0) return v;
  MatrixXd basis(v.size(), most), T = MatrixXd::Zero(most, most);
  basis.col(0) = v / length;
  Eigen::Index n = 0;
  while (n < most) {
    VectorXd next = Q(basis.col(n));
    T(n, n) = basis.col(n).dot(next);
    // Twice: once leaves rounding that grows.
    for (int round = 0; round < 2; ++round) {
      const VectorXd along = basis.leftCols(n + 1).transpose() * next;
      next -= basis.leftCols(n + 1) * along;
    }
    const double rest = next.norm();
    if (++n == most || rest < kSingular) break;
    T(n, n - 1) = T(n - 1, n) = rest;
    basis.col(n) = next / rest;
  }
  return length * (basis.leftCols(n) * adjustment(T.topLeftCorner(n, n)).col(0));
}

// sum_b u_b u_b', drawn towards a multiple of the identity.
MatrixXd shrunk(const MatrixXd& u) {
  const auto n = double(u.cols());
  const MatrixXd S = u * u.transpose();
  const MatrixXd target = S.diagonal().mean() * MatrixXd::Identity(S.rows(), S.cols());
  // The sum is n times the mean of u u'; its variance comes from their scatter about that mean.
  double variance = 0.0;
  for (Eigen::Index b = 0; b < u.cols(); ++b) {
    variance += (n * u.col(b) * u.col(b).transpose() - S).squaredNorm() / (n * n);
  }
  const double distance = (S - target).squaredNorm();
  const double lambda = distance > 0.0 ? std::min(1.0, variance / distance) : 1.0;
  return (1.0 - lambda) * S + lambda * target;
}

MatrixXd at_least_identity(const MatrixXd& S) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(S);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(1.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

// u: the adjusted scores, one column a block.
MatrixXd sandwich(const Root& root, const MatrixXd& u) {
  // What so few blocks say of the scatter is itself uncertain: errors over it follow Student's
  // distribution.
  const double few = student_variance(int(u.cols()));
  return root.L * at_least_identity(few * shrunk(u)) * root.L.transpose();
}

MatrixXd adjusted_scores(const LinearSystem& system, const MatrixXd& H_columns, const Root& root,
                         const std::vector<int>& block_of_row, int blocks) {
  BlockSums sums = sums_of(system, H_columns * root.inverse.transpose(), block_of_row, blocks);
  for (std::size_t b = 0; b < sums.leverage.size(); ++b) {
    const auto at = Eigen::Index(b);
    sums.score.col(at) = adjustment(sums.leverage[b]) * sums.score.col(at);
  }
  return std::move(sums.score);
}

MatrixXd adjusted_scores(const Root& root, const std::vector<BlockScore>& blocks) {
  MatrixXd u(root.L.cols(), Eigen::Index(blocks.size()));
  const bool wide = root.L.rows() > kWideSandwich;
  parallel::for_each(blocks.size(), [&](std::size_t b) {
    const VectorXd score = root.L.transpose() * blocks[b].score;
    const MatrixXd& A = blocks[b].information;
    const auto product = [&](const VectorXd& v) -> VectorXd {
      return root.L.transpose() * (A * (root.L * v));
    };
    u.col(Eigen::Index(b)) = wide ? adjusted(product, score)
                                  : VectorXd(adjustment(root.L.transpose() * A * root.L) * score);
  });
  return u;
}

}  // namespace

MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const MatrixXd& covariance, const std::vector<int>& block_of_row,
                             int blocks, MatrixXd& moved) {
  const Root root = root_of(covariance);
  if (blocks < 2) {  // no scatter to go by
    moved = root.L;
    return covariance;
  }
  const MatrixXd u = adjusted_scores(system, H_columns, root, block_of_row, blocks);
  moved = root.L * u;
  return sandwich(root, u);
}

MatrixXd sandwich_covariance(const MatrixXd& covariance, const std::vector<BlockScore>& blocks,
                             MatrixXd& moved) {
  const Root root = root_of(covariance);
  if (blocks.size() < 2) {
    moved = root.L;
    return covariance;
  }
  const MatrixXd u = adjusted_scores(root, blocks);
  moved = root.L * u;
  return sandwich(root, u);
}

MatrixXd sandwich_covariance(const LinearSystem& system, const MatrixXd& H_columns,
                             const MatrixXd& covariance, const std::vector<int>& block_of_row,
                             int blocks) {
  MatrixXd moved;
  return sandwich_covariance(system, H_columns, covariance, block_of_row, blocks, moved);
}

MatrixXd sandwich_covariance(const MatrixXd& covariance, const std::vector<BlockScore>& blocks) {
  MatrixXd moved;
  return sandwich_covariance(covariance, blocks, moved);
}

MatrixXd sandwich_of_moves(const MatrixXd& covariance, const MatrixXd& moved) {
  const Root root = root_of(covariance);
  return sandwich(root, root.inverse * moved);
}

double student_variance(int blocks) { return blocks > 4 ? (blocks - 1.0) / (blocks - 3.0) : 3.0; }

}  // namespace magimu
