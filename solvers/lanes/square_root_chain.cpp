// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/square_root_chain.h"

#include <algorithm>
#include <cmath>

namespace magimu::lanes {
namespace {

constexpr int kMoreRows = 64;  // on the root before they are reduced to its triangle

}  // namespace

SquareRootChain::SquareRootChain(const Layout& layout) : BoundaryChain(layout), chain_(g_ + 1) {
  gathered_.resize(std::size_t(boundaries() * 2 * d_ * wide()));
  for (Root* root : {&gathered_root_, &root_}) {
    root->rows = RowBlock::Zero(2 * g_ + kMoreRows, g_ + 1);
  }
}

double* SquareRootChain::Root::next() {
  if (filled == rows.rows()) reduce();
  rows.row(filled).setZero();
  return rows.row(filled++).data();
}

void SquareRootChain::Root::reduce() {
  rows.bottomRows(rows.rows() - filled).setZero();
  std::vector<int> pivots;
  filled = triangularize(rows, 0, 0, int(rows.cols()) - 1, pivots);
}

void SquareRootChain::clear() {
  BoundaryChain::clear();
  std::fill(gathered_.begin(), gathered_.end(), 0.0);
  gathered_root_.filled = 0;
  gathered_gain_ = 0.0;
}

void SquareRootChain::add(int window, const double* out, int lane, int lanes) {
  const auto at = [&](int i) { return out[std::ptrdiff_t(i) * lanes + lane]; };
  const int left = boundary_of(window), width = wide();
  double* rows = gathered_.data() + std::size_t(left * 2 * d_ * width);
  for (int i = 0; i < d_; ++i, rows += width) {
    const int from = i * (d_ + b_);
    for (int j = 0; j < d_; ++j) rows[d_ + j] = at(from + j);
    for (int j = 0; j < d_; ++j) rows[j] = at(from + d_ + j);
    for (int j = 0; j <= g_; ++j) rows[2 * d_ + j] = at(from + 2 * d_ + j);
  }
  const int triangle = border_triangle_at(d_, b_);
  for (int i = 0; i < d_; ++i, rows += width) {
    const int from = triangle + triangle_at(i, b_) - i;
    for (int j = i; j < d_; ++j) rows[j] = at(from + j);
    for (int j = 0; j <= g_; ++j) rows[2 * d_ + j] = at(from + d_ + j);
  }
  for (int i = 0; i < g_; ++i) {
    const int from = triangle + triangle_at(d_ + i, b_) - i;
    double* row = gathered_root_.next();
    for (int j = i; j <= g_; ++j) row[j] = at(from + j);
  }
  add_norms(window, out + raw_norms_at(d_, b_) * lanes, lane, lanes);
  gathered_gain_ += at(gained_at(d_, b_));
}

void SquareRootChain::add_global(const std::vector<int>& columns, int rows, const double* J) {
  BoundaryChain::add_global(columns, rows, J);
  const auto n = columns.size();
  for (int r = 0; r < rows; ++r, J += n + 1) {
    double* row = gathered_root_.next();
    for (std::size_t i = 0; i < n; ++i) row[columns[i]] += J[i];
    row[g_] = J[n];
  }
}

// Stacks three blocks of rows: those carried from earlier windows, those of the window to the next
// boundary, and the damping. The rows that are left on the next boundary are carried on.
bool SquareRootChain::eliminate_boundary(int boundary, double damping) {
  const int width = wide(), of_window = linked(boundary) ? 2 * d_ : 0;
  RowStack& A = chain_.stack(d_, d_, of_window + d_);
  const double* window = gathered_.data() + std::size_t(boundary * 2 * d_ * width);
  int filled = chain_.first_row();
  for (int i = 0; i < of_window; ++i, window += width) std::copy_n(window, width, A.row(filled++));
  for (int i = 0; i < d_; ++i) {
    A.row(filled++)[i] = std::sqrt(damping * positive_diagonal(boundary, i));
  }
  chain_.eliminate();
  if (chain_.end_of_node() < d_) return false;
  for (int i = 0; i < d_; ++i) {
    const double pivot = A.row(i)[i], z = A.row(i)[width - 1];
    pivot_ = std::min(pivot_, pivot * pivot / (positive_diagonal(boundary, i) * (1.0 + damping)));
    inverse_[std::size_t(boundary * d_ + i)] = 1.0 / pivot;
    gained_ += z * z;
    std::copy_n(A.row(i), width, row(rows_, boundary, i));
  }
  for (int i = chain_.end_of_next(); i < A.rows(); ++i) {
    std::copy_n(A.row(i) + 2 * d_, g_ + 1, root_.next());
  }
  return true;
}

bool SquareRootChain::eliminate(double damping) {
  gathered_root_.reduce();
  root_.rows = gathered_root_.rows;
  root_.filled = gathered_root_.filled;
  gained_ = gathered_gain_;
  pivot_ = 1.0;
  chain_.begin_chain();
  for (int i = 0; i < boundaries(); ++i) {
    if (!eliminate_boundary(i, damping)) return false;
  }
  for (int i = 0; i < g_; ++i) {
    root_.next()[i] = std::sqrt(damping * positive(root_diagonal_[i]));
  }
  root_.reduce();
  if (root_.filled < g_) return false;
  if (g_ == 0) return true;
  scale_ = root_scale(damping);
  qr_.compute(MatrixXd(root_.rows.topLeftCorner(g_, g_) * scale_.asDiagonal()));
  const VectorXd z = qr_.householderQ().adjoint() * root_.rows.col(g_).head(g_);
  const double least = qr_.matrixQR().diagonal().cwiseAbs().minCoeff();
  pivot_ = std::min(pivot_, least * least);
  gained_ += z.squaredNorm();
  if (!(std::isfinite(gained_) && pivot_ > 0.0)) return false;
  delta_globals_ = -scale_.cwiseProduct(
      qr_.colsPermutation() *
      qr_.matrixR().topLeftCorner(g_, g_).triangularView<Eigen::Upper>().solve(z));
  return true;
}

MatrixXd SquareRootChain::covariance_globals() const {
  MatrixXd half = MatrixXd::Identity(g_, g_);
  qr_.matrixR().topLeftCorner(g_, g_).triangularView<Eigen::Upper>().solveInPlace(half);
  half = scale_.asDiagonal() * (qr_.colsPermutation() * half);
  return half * half.transpose();
}

}  // namespace magimu::lanes
