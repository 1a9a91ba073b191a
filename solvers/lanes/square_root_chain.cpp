// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/square_root_chain.h"

#include <algorithm>
#include <cmath>

namespace magimu::lanes {
namespace {

constexpr int kMoreRows = 64;  // on the root before they are reduced to its triangle

}  // namespace

SquareRootChain::SquareRootChain(const Layout& layout) : BoundaryChain(layout) {
  gathered_.resize(std::size_t(boundaries() * 2 * d_ * wide()));
  carried_.resize(0, wide());
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
  const bool link = linked(boundary);
  const int width = wide(), more = link ? 2 * d_ : 0, carried = int(carried_.rows());
  stack_.setZero(carried + more + d_, width);
  stack_.topRows(carried) = carried_;
  const double* window = gathered_.data() + std::size_t(boundary * 2 * d_ * width);
  std::copy(window, window + more * width, stack_.row(carried).data());
  for (int i = 0; i < d_; ++i) {
    stack_(carried + more + i, i) = std::sqrt(damping * positive_diagonal(boundary, i));
  }
  if (triangularize(stack_, 0, 0, d_, pivots_) < d_) return false;
  for (int i = 0; i < d_; ++i) {
    const double pivot = stack_(i, i), z = stack_(i, width - 1);
    pivot_ = std::min(pivot_, pivot * pivot / (positive_diagonal(boundary, i) * (1.0 + damping)));
    inverse_[std::size_t(boundary * d_ + i)] = 1.0 / pivot;
    gained_ += z * z;
  }
  std::copy_n(stack_.data(), d_ * width, row(rows_, boundary, 0));
  const int end = link ? triangularize(stack_, d_, d_, 2 * d_, pivots_) : d_;
  carried_.setZero(end - d_, width);
  if (end > d_) {
    carried_.leftCols(d_) = stack_.block(d_, d_, end - d_, d_);
    carried_.rightCols(g_ + 1) = stack_.block(d_, 2 * d_, end - d_, g_ + 1);
  }
  for (int i = end; i < int(stack_.rows()); ++i) {
    std::copy_n(stack_.row(i).data() + 2 * d_, g_ + 1, root_.next());
  }
  return true;
}

bool SquareRootChain::eliminate(double damping) {
  gathered_root_.reduce();
  root_.rows = gathered_root_.rows;
  root_.filled = gathered_root_.filled;
  gained_ = gathered_gain_;
  pivot_ = 1.0;
  carried_.resize(0, wide());
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
