// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/information_chain.h"

#include <algorithm>
#include <cmath>

namespace magimu::lanes {

InformationChain::InformationChain(const Layout& layout) : BoundaryChain(layout) {
  gathered_.resize(rows_.size());
  root_.resize(g_ + 1, g_ + 1);
}

void InformationChain::clear() {
  BoundaryChain::clear();
  std::fill(gathered_.begin(), gathered_.end(), 0.0);
  root_.setZero();
}

void InformationChain::add(int window, const double* out, int lane, int lanes) {
  const auto at = [&](int i) { return out[std::ptrdiff_t(i) * lanes + lane]; };
  const int left = boundary_of(window), right = left + 1, next = d_, border = 2 * d_;
  const int raw = d_ * d_ + d_ * b_, taken = raw + block_doubles(b_);
  const auto total = [&](int i, int j) {
    const int k = block_index(i, j, b_);
    return at(raw + k) - at(taken + k);
  };
  for (int i = 0; i < d_; ++i) {
    double* to = row(gathered_, right, i);
    for (int j = i; j < d_; ++j) to[j] += at(i * d_ + j);
    for (int j = 0; j <= g_; ++j) to[border + j] += at(d_ * d_ + i * b_ + d_ + j);
    diagonal_[std::size_t(right * d_ + i)] += at(raw_at(d_, b_) + i);
    gradient_[std::size_t(right * d_ + i)] += at(raw_at(d_, b_) + d_ + i);
  }
  for (int i = 0; i < d_; ++i) {
    double* to = row(gathered_, left, i);
    for (int j = i; j < d_; ++j) to[j] += total(i, j);
    for (int j = 0; j < d_; ++j) to[next + j] += at(d_ * d_ + j * b_ + i);
    for (int j = 0; j <= g_; ++j) to[border + j] += total(i, d_ + j);
    diagonal_[std::size_t(left * d_ + i)] += at(raw + block_index(i, i, b_));
    gradient_[std::size_t(left * d_ + i)] += at(raw + block_index(i, b_ - 1, b_));
  }
  for (int i = 0; i < g_; ++i) {
    for (int j = i; j <= g_; ++j) root_(i, j) += total(d_ + i, d_ + j);
    root_diagonal_[i] += at(raw + block_index(d_ + i, d_ + i, b_));
    root_gradient_[i] += at(raw + block_index(d_ + i, b_ - 1, b_));
  }
  const int last = block_index(b_ - 1, b_ - 1, b_);
  squares_ += at(raw + last);
  root_(g_, g_) += at(taken + last);  // what inner nodes have gained
}

void InformationChain::add_global(const std::vector<int>& columns, int rows, const double* J) {
  BoundaryChain::add_global(columns, rows, J);
  const auto n = columns.size();
  for (int r = 0; r < rows; ++r, J += n + 1) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        if (columns[i] <= columns[j]) root_(columns[i], columns[j]) += J[i] * J[j];
      }
      root_(columns[i], g_) += J[i] * J[n];
    }
  }
}

void InformationChain::eliminate_boundary(int boundary, double damping) {
  const int width = wide();
  for (int i = 0; i < d_; ++i) {
    row(rows_, boundary, i)[i] += damping * positive_diagonal(boundary, i);
  }
  for (int i = 0; i < d_; ++i) {
    double* own = row(rows_, boundary, i);
    pivot_ = std::min(pivot_, own[i] / (positive_diagonal(boundary, i) * (1.0 + damping)));
    const double inverse = 1.0 / std::sqrt(own[i]);
    inverse_[std::size_t(boundary * d_ + i)] = inverse;
    for (int j = i; j < width; ++j) own[j] *= inverse;
    for (int k = i + 1; k < d_; ++k) {
      double* other = row(rows_, boundary, k);
      for (int j = k; j < width; ++j) other[j] -= own[k] * own[j];
    }
    const double *border = own + 2 * d_, *next = own + d_;
    gained_ += border[g_] * border[g_];
    for (int p = 0; p < g_; ++p) {
      for (int q = p; q <= g_; ++q) damped_root_(p, q) -= border[p] * border[q];
    }
    if (!linked(boundary)) continue;
    for (int p = 0; p < d_; ++p) {
      double* to = row(rows_, boundary + 1, p);
      for (int q = p; q < d_; ++q) to[q] -= next[p] * next[q];
      for (int q = 0; q <= g_; ++q) to[2 * d_ + q] -= next[p] * border[q];
    }
  }
}

bool InformationChain::eliminate(double damping) {
  rows_ = gathered_;
  damped_root_ = root_;
  gained_ = root_(g_, g_);
  pivot_ = 1.0;
  for (int i = 0; i < boundaries(); ++i) eliminate_boundary(i, damping);
  // The root in columns of unit norm.
  scale_ = root_scale(damping);
  for (int i = 0; i < g_; ++i) damped_root_(i, i) += damping * positive(root_diagonal_[i]);
  damped_root_.topLeftCorner(g_, g_).triangularView<Eigen::StrictlyLower>() =
      damped_root_.topLeftCorner(g_, g_).transpose();
  llt_.compute(
      MatrixXd(scale_.asDiagonal() * damped_root_.topLeftCorner(g_, g_) * scale_.asDiagonal()));
  if (llt_.info() != Eigen::Success) return false;
  const VectorXd pivots = llt_.matrixLLT().diagonal();
  if (g_ > 0) pivot_ = std::min(pivot_, pivots.minCoeff() * pivots.minCoeff());
  VectorXd z = -scale_.cwiseProduct(damped_root_.col(g_).head(g_));
  llt_.matrixL().solveInPlace(z);
  gained_ += z.squaredNorm();
  llt_.matrixU().solveInPlace(z);
  delta_globals_ = scale_.cwiseProduct(z);
  return std::isfinite(gained_) && pivot_ > 0.0;
}

MatrixXd InformationChain::covariance_globals() const {
  return scale_.asDiagonal() * MatrixXd(llt_.solve(MatrixXd(MatrixXd::Identity(g_, g_)))) *
         scale_.asDiagonal();
}

}  // namespace magimu::lanes
