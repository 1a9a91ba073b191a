// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/boundary_chain.h"

#include <algorithm>
#include <cmath>

#include "solvers/lanes/information_chain.h"
#include "solvers/lanes/square_root_chain.h"

namespace magimu::lanes {

std::unique_ptr<BoundaryChain> BoundaryChain::make(const Layout& layout, EliminationForm form) {
  if (form == EliminationForm::kInformation) return std::make_unique<InformationChain>(layout);
  return std::make_unique<SquareRootChain>(layout);
}

BoundaryChain::BoundaryChain(const Layout& layout)
    : d_(layout.d), g_(layout.globals), b_(layout.b()) {
  for (const Layout::Window& w : layout.windows) {
    if (w.begins) chain_begins_.push_back(1);
    first_.push_back(int(chain_begins_.size()) - 1);
    chain_begins_.push_back(0);
  }
  const std::size_t n = chain_begins_.size(), d = std::size_t(d_);
  rows_.resize(n * d * std::size_t(wide()));
  inverse_.resize(n * d);
  diagonal_.resize(n * d);
  gradient_.resize(n * d);
  delta_.resize(n * d);
  root_diagonal_.resize(g_);
  root_gradient_.resize(g_);
}

void BoundaryChain::clear() {
  for (auto* v : {&diagonal_, &gradient_}) std::fill(v->begin(), v->end(), 0.0);
  root_diagonal_.setZero();
  root_gradient_.setZero();
  squares_ = 0.0;
}

void BoundaryChain::add_norms(int window, const double* norms, int lane, int lanes) {
  const auto at = [&](int i) { return norms[std::ptrdiff_t(i) * lanes + lane]; };
  const int left = boundary_of(window), right = left + 1, border = 2 * d_;
  for (int i = 0; i < d_; ++i) {
    diagonal_[std::size_t(right * d_ + i)] += at(i);
    gradient_[std::size_t(right * d_ + i)] += at(d_ + i);
    diagonal_[std::size_t(left * d_ + i)] += at(border + i);
    gradient_[std::size_t(left * d_ + i)] += at(border + b_ + i);
  }
  for (int i = 0; i < g_; ++i) {
    root_diagonal_[i] += at(border + d_ + i);
    root_gradient_[i] += at(border + b_ + d_ + i);
  }
  squares_ += at(border + b_ - 1);
}

void BoundaryChain::add_global(const std::vector<int>& columns, int rows, const double* J) {
  const auto n = columns.size();
  for (int r = 0; r < rows; ++r, J += n + 1) {
    for (std::size_t i = 0; i < n; ++i) {
      root_diagonal_[columns[i]] += J[i] * J[i];
      root_gradient_[columns[i]] += J[i] * J[n];
    }
    squares_ += J[n] * J[n];
  }
}

VectorXd BoundaryChain::root_scale(double damping) const {
  return root_diagonal_.unaryExpr(
      [&](double diagonal) { return 1.0 / std::sqrt(positive(diagonal) * (1.0 + damping)); });
}

void BoundaryChain::solve() {
  for (int i = boundaries() - 1; i >= 0; --i) {
    for (int r = d_ - 1; r >= 0; --r) {
      const double* own = row(rows_, i, r);
      double sum = own[2 * d_ + g_];
      for (int j = 0; j < g_; ++j) sum += own[2 * d_ + j] * delta_globals_[j];
      for (int j = 0; linked(i) && j < d_; ++j)
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
