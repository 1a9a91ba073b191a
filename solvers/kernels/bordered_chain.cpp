// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/bordered_chain.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace magimu {
namespace {

constexpr int kEliminated = 64;  // eliminated rows that are subtracted at once

}  // namespace

BorderedChain::BorderedChain(int border, int max_dim, double tiny)
    : code_(lanes::rank_code(best_isa())),
      tiny_(tiny),
      border_(border),
      stride_(2 * max_dim),
      A_(std::size_t(stride_ * stride_), 0.0),
      taken_(std::size_t(stride_), 0.0),
      inverse_(std::size_t(stride_), 0.0),
      rows_(std::size_t(kEliminated + stride_) * std::size_t(border_.width()),
            AlignedBuffer::Fill::kNone) {}

double* BorderedChain::row(int i) {
  return rows_.data() + std::ptrdiff_t(eliminated_ + i) * border_.width();
}

void BorderedChain::clear() {
  border_.clear();
  eliminated_ = nodes_ = older_ = newer_ = 0;
  log_det_ = 0.0;
  least_pivot_ = 1.0;
}

void BorderedChain::push(int dim) {
  ++nodes_;
  older_ = newer_;
  newer_ = dim;
  for (int i = 0; i < unknowns(); ++i) {
    for (int j = std::max(i, older_); j < unknowns(); ++j) information(i, j) = 0.0;
  }
  std::fill_n(taken_.begin() + older_, dim, 0.0);
  std::fill_n(row(older_), std::ptrdiff_t(dim) * border_.width(), 0.0);
}

// [U W] of the first n unknowns, and the others' information less W'W.
void BorderedChain::factorize(int n, int all) {
  for (int i = 0; i < n; ++i) {
    const double before = information(i, i) + taken(i);
    double pivot = information(i, i);
    for (int k = 0; k < i; ++k) pivot -= information(k, i) * information(k, i);
    const bool free = pivot <= tiny_ * before + 1e-30;
    if (before > 0.0) least_pivot_ = std::min(least_pivot_, std::max(0.0, pivot / before));
    const double root = free ? 1.0 : std::sqrt(pivot);
    log_det_ += 2.0 * std::log(root);
    information(i, i) = root;
    inverse_[std::size_t(i)] = free ? 0.0 : 1.0 / root;
    for (int j = i + 1; j < all; ++j) {
      double x = information(i, j);
      for (int k = 0; k < i; ++k) x -= information(k, i) * information(k, j);
      information(i, j) = x * inverse_[std::size_t(i)];
    }
  }
  for (int i = n; i < all; ++i) {
    for (int k = 0; k < n; ++k) {
      taken(i) += information(k, i) * information(k, i);
      for (int j = i; j < all; ++j) information(i, j) -= information(k, i) * information(k, j);
    }
  }
}

void BorderedChain::factorize() {
  const int n = eliminating(), all = unknowns();
  factorize(n, all);
  code_.eliminate(A_.data(), stride_, inverse_.data(), n, all - n, row(0), border_.width());
}

void BorderedChain::drop() {
  const int n = eliminating(), all = unknowns();
  eliminated_ += n;
  for (int i = n; i < all; ++i) {
    for (int j = i; j < all; ++j) information(i - n, j - n) = information(i, j);
    taken(i - n) = taken(i);
  }
  --nodes_;
  older_ = 0;
  newer_ = all - n;
  if (eliminated_ >= kEliminated - stride_ / 2) subtract();
}

void BorderedChain::subtract() {
  if (eliminated_ > 0) border_.subtract(rows_.data(), eliminated_);
  const double* const left = row(0);
  eliminated_ = 0;
  std::copy_n(left, std::ptrdiff_t(unknowns()) * border_.width(), row(0));
}

void BorderedChain::finish() {
  subtract();
  border_.finish();
}

void BorderedChain::pull(const std::vector<double>& diagonal) {
  const int dim = int(diagonal.size());
  const int width = border_.width();
  for (int i = newer_ - 1; i >= 0; --i) {
    for (int j = newer_ - 1; j >= i; --j) information(dim + i, dim + j) = information(i, j);
    taken(dim + i) = taken(i);
    std::copy_n(row(i), width, row(dim + i));
  }
  for (int i = dim; i < dim + newer_; ++i) {
    for (int j = 0; j < dim; ++j) information(j, i) = row(i)[j];
    std::fill_n(row(i), dim, 0.0);
  }
  for (int i = 0; i < dim; ++i) {
    for (int j = i; j < dim; ++j) information(i, j) = std::as_const(border_)(i, j);
    taken(i) = diagonal[std::size_t(i)] - information(i, i);
    std::fill_n(row(i), width, 0.0);
    for (int j = dim; j < border_.columns(); ++j) row(i)[j] = std::as_const(border_)(i, j);
  }
  (nodes_ == 0 ? newer_ : older_) = dim;
  ++nodes_;
}

}  // namespace magimu
