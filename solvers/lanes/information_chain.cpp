// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/information_chain.h"

#include <algorithm>
#include <cmath>

namespace magimu::lanes {

InformationChain::InformationChain(const Layout& layout)
    : BoundaryChain(layout), chain_(g_ + 1, d_, 0.0) {
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

// As the chain's newer node.
void InformationChain::enter(int boundary, double damping) {
  chain_.push(d_);
  const int at = chain_.older();
  for (int i = 0; i < d_; ++i) {
    const double* const from = row(gathered_, boundary, i);
    for (int j = i; j < d_; ++j) chain_.information(at + i, at + j) = from[j];
    const double diagonal = positive_diagonal(boundary, i);
    chain_.information(at + i, at + i) += damping * diagonal;
    // By the elimination of inner nodes.
    chain_.taken(at + i) = diagonal * (1.0 + damping) - chain_.information(at + i, at + i);
    std::copy_n(from + 2 * d_, g_ + 1, chain_.row(at + i));
  }
}

void InformationChain::eliminate_boundary(int boundary, double damping) {
  if (chain_.nodes() == 0) enter(boundary, damping);
  if (linked(boundary)) {
    enter(boundary + 1, damping);
    for (int i = 0; i < d_; ++i) {
      const double* const next = row(gathered_, boundary, i) + d_;
      for (int j = 0; j < d_; ++j) chain_.information(i, d_ + j) = next[j];
    }
  }
  chain_.factorize();
  for (int i = 0; i < d_; ++i) {
    double* const to = row(rows_, boundary, i);
    for (int j = i; j < chain_.unknowns(); ++j) to[j] = chain_.information(i, j);
    std::copy_n(chain_.row(i), g_ + 1, to + 2 * d_);
    inverse_[std::size_t(boundary * d_ + i)] = chain_.inverse(i);
  }
  chain_.drop();
}

bool InformationChain::eliminate(double damping) {
  chain_.clear();
  SquareSum& border = chain_.border();
  for (int i = 0; i < g_; ++i) {
    for (int j = i; j <= g_; ++j) border(i, j) = root_(i, j);
  }
  for (int i = 0; i < boundaries(); ++i) eliminate_boundary(i, damping);
  chain_.finish();
  gained_ = root_(g_, g_) - border(g_, g_);
  pivot_ = chain_.least_pivot();
  // The root in columns of unit norm.
  scale_ = root_scale(damping);
  MatrixXd scaled(g_, g_);
  VectorXd z(g_);
  for (int i = 0; i < g_; ++i) {
    border(i, i) += damping * positive(root_diagonal_[i]);
    for (int j = i; j < g_; ++j) scaled(j, i) = scale_[i] * border(i, j) * scale_[j];
    z[i] = -scale_[i] * border(i, g_);
  }
  llt_.compute(scaled);
  if (llt_.info() != Eigen::Success) return false;
  const VectorXd pivots = llt_.matrixLLT().diagonal();
  if (g_ > 0) pivot_ = std::min(pivot_, pivots.minCoeff() * pivots.minCoeff());
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
