// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/boundary_chain.h"

#include <algorithm>
#include <cmath>

namespace magimu::lanes {
namespace {

double positive(double diagonal) { return diagonal > 0.0 ? diagonal : 1.0; }

}  // namespace

BoundaryChain::BoundaryChain(const Layout& layout)
    : d_(layout.d), g_(layout.globals), b_(layout.b()) {
  for (const Layout::Window& w : layout.windows) {
    if (w.begins) chain_begins_.push_back(1);
    first_.push_back(int(chain_begins_.size()) - 1);
    chain_begins_.push_back(0);
  }
  const std::size_t n = chain_begins_.size(), d = std::size_t(d_);
  gathered_.resize(n * d * std::size_t(wide()));
  inverse_.resize(n * d);
  diagonal_.resize(n * d);
  gradient_.resize(n * d);
  delta_.resize(n * d);
  root_.resize(g_ + 1, g_ + 1);
  root_diagonal_.resize(g_);
  root_gradient_.resize(g_);
}

void BoundaryChain::clear() {
  for (auto* v : {&gathered_, &diagonal_, &gradient_}) std::fill(v->begin(), v->end(), 0.0);
  root_.setZero();
  root_diagonal_.setZero();
  root_gradient_.setZero();
  squares_ = 0.0;
}

void BoundaryChain::add(int window, const double* out, int lane, int lanes) {
  const auto at = [&](int i) { return out[std::ptrdiff_t(i) * lanes + lane]; };
  const int left = first_[std::size_t(window)], right = left + 1, next = d_, border = 2 * d_;
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

void BoundaryChain::add_global(const std::vector<int>& columns, int rows, const double* J) {
  const auto n = columns.size();
  for (int r = 0; r < rows; ++r, J += n + 1) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        if (columns[i] <= columns[j]) root_(columns[i], columns[j]) += J[i] * J[j];
      }
      root_(columns[i], g_) += J[i] * J[n];
      root_diagonal_[columns[i]] += J[i] * J[i];
      root_gradient_[columns[i]] += J[i] * J[n];
    }
    squares_ += J[n] * J[n];
  }
}

void BoundaryChain::eliminate_boundary(int boundary, double damping) {
  const int width = wide();
  for (int i = 0; i < d_; ++i) {
    double* own = row(rows_, boundary, i);
    const double diagonal = positive(diagonal_[std::size_t(boundary * d_ + i)]);
    own[i] += damping * diagonal;
  }
  for (int i = 0; i < d_; ++i) {
    double* own = row(rows_, boundary, i);
    const double diagonal = positive(diagonal_[std::size_t(boundary * d_ + i)]);
    pivot_ = std::min(pivot_, own[i] / (diagonal * (1.0 + damping)));
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
    if (boundary + 1 == boundaries() || chain_begins_[std::size_t(boundary) + 1] != 0) continue;
    for (int p = 0; p < d_; ++p) {
      double* to = row(rows_, boundary + 1, p);
      for (int q = p; q < d_; ++q) to[q] -= next[p] * next[q];
      for (int q = 0; q <= g_; ++q) to[2 * d_ + q] -= next[p] * border[q];
    }
  }
}

bool BoundaryChain::eliminate(double damping) {
  rows_ = gathered_;
  damped_root_ = root_;
  gained_ = root_(g_, g_);
  pivot_ = 1.0;
  for (int i = 0; i < boundaries(); ++i) eliminate_boundary(i, damping);
  // The root in columns of unit norm.
  VectorXd scale(g_);
  for (int i = 0; i < g_; ++i) {
    damped_root_(i, i) += damping * positive(root_diagonal_[i]);
    scale[i] = 1.0 / std::sqrt(positive(root_diagonal_[i]) * (1.0 + damping));
  }
  damped_root_.topLeftCorner(g_, g_).triangularView<Eigen::StrictlyLower>() =
      damped_root_.topLeftCorner(g_, g_).transpose();
  llt_.compute(scale.asDiagonal() * damped_root_.topLeftCorner(g_, g_) * scale.asDiagonal());
  if (llt_.info() != Eigen::Success) return false;
  const VectorXd pivots = llt_.matrixLLT().diagonal();
  if (g_ > 0) pivot_ = std::min(pivot_, pivots.minCoeff() * pivots.minCoeff());
  VectorXd z = -scale.cwiseProduct(damped_root_.col(g_).head(g_));
  llt_.matrixL().solveInPlace(z);
  gained_ += z.squaredNorm();
  llt_.matrixU().solveInPlace(z);
  delta_globals_ = scale.cwiseProduct(z);
  return std::isfinite(gained_) && pivot_ > 0.0;
}

void BoundaryChain::solve() {
  for (int i = boundaries() - 1; i >= 0; --i) {
    const bool linked = i + 1 < boundaries() && chain_begins_[std::size_t(i) + 1] == 0;
    for (int r = d_ - 1; r >= 0; --r) {
      const double* own = row(rows_, i, r);
      double sum = own[2 * d_ + g_];
      for (int j = 0; j < g_; ++j) sum += own[2 * d_ + j] * delta_globals_[j];
      for (int j = 0; linked && j < d_; ++j)
        sum += own[d_ + j] * delta_[std::size_t((i + 1) * d_ + j)];
      for (int j = r + 1; j < d_; ++j) sum += own[j] * delta_[std::size_t(i * d_ + j)];
      delta_[std::size_t(i * d_ + r)] = -sum * inverse_[std::size_t(i * d_ + r)];
    }
  }
}

double BoundaryChain::gradient() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < diagonal_.size(); ++i) {
    sum += gradient_[i] * gradient_[i] / positive(diagonal_[i]);
  }
  for (int i = 0; i < g_; ++i) {
    sum += root_gradient_[i] * root_gradient_[i] / positive(root_diagonal_[i]);
  }
  return sum;
}

double BoundaryChain::sum_damped() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < delta_.size(); ++i) sum += diagonal_[i] * delta_[i] * delta_[i];
  return sum + root_diagonal_.dot(delta_globals_.cwiseAbs2());
}

double BoundaryChain::sum_squares() const {
  double sum = delta_globals_.squaredNorm();
  for (const double x : delta_) sum += x * x;
  return sum;
}

}  // namespace magimu::lanes
