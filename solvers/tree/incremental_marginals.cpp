// SPDX-License-Identifier: BSD-3-Clause
// How sure an IncrementalQr is of its front: covariance, information and what is undetermined, all
// from the triangles at the root.
#include <algorithm>
#include <stdexcept>

#include "graph/decompositions.h"
#include "graph/numerical_error.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {
namespace {

// Columns of unit norm (zero ones stay).
VectorXd unit_columns(const RowBlock& T) {
  return T.colwise().norm().transpose().unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 1.0; });
}

std::vector<NullDirection> null_directions(const RowBlock& T) {
  if (T.cols() == 0) return {};
  const VectorXd scale = unit_columns(T);
  const Eigen::JacobiSVD<MatrixXd> svd(T * scale.asDiagonal(), Eigen::ComputeFullV);
  std::vector<NullDirection> out;
  for (Eigen::Index i = T.cols() - 1; i >= 0; --i) {
    const double value = i < svd.singularValues().size() ? svd.singularValues()[i] : 0.0;
    if (value >= kNullTolerance) break;
    out.push_back({value, scale.cwiseProduct(svd.matrixV().col(i))});
  }
  return out;
}

}  // namespace

void IncrementalQr::require_in_front(const Values& front, const std::vector<Key>& keys) const {
  for (const Key key : keys) {
    if (front.contains(key)) continue;
    throw std::invalid_argument(
        is_past(key)
            ? to_string(key) +
                  " is of a node before the last one of its chain: an IncrementalQr knows how sure "
                  "the globals and each chain's last node are; take Marginals(estimator.graph(), "
                  "estimator.estimate()) for the others"
            : to_string(key) + " has come with no update");
  }
}

// The triangle of some variables of the front, all others eliminated: [variables], square.
RowBlock IncrementalQr::triangle_of(const std::vector<Key>& keys) const {
  const Values now = front();
  require_in_front(now, keys);
  int wanted = 0;
  for (const Key key : keys) wanted += now.slot(key).type.tangent();
  const int rest = now.dim() - wanted;
  // Where each column of the front goes: those that are not wanted first.
  std::vector<int> to(std::size_t(now.dim()), -1);
  int next = rest;
  for (const Key key : keys) {
    const Values::Slot& s = now.slot(key);
    for (int c = 0; c < s.type.tangent(); ++c) to[std::size_t(s.tangent + c)] = next++;
  }
  next = 0;
  for (int& c : to) {
    if (c < 0) c = next++;
  }
  int rows = root_.globals;
  for (const Chain& chain : chains_) rows += chain.tree.root().last;
  RowBlock A = RowBlock::Zero(rows, now.dim());
  for (int c = 0; c < root_.globals; ++c) {
    A.col(to[std::size_t(c)]).head(root_.globals) = root_.R.col(c);
  }
  // The front holds the last nodes behind the globals, chain by chain, as the triangles do.
  int row = root_.globals, column = anchors_.dim();
  for (const Chain& chain : chains_) {
    const CondensedTriangle& t = chain.tree.root();
    for (int c = 0; c < t.last; ++c) {
      A.col(to[std::size_t(column + c)]).segment(row, t.last) = t.R.col(c).head(t.last);
    }
    for (int c = 0; c < t.globals; ++c) {
      A.col(to[std::size_t(c)]).segment(row, t.last) = t.R.col(t.last + c).head(t.last);
    }
    row += t.last;
    column += t.last;
  }
  std::vector<int> pivots;
  const int below = triangularize(A, 0, 0, rest, pivots);
  RowBlock out = RowBlock::Zero(wanted, wanted);
  const int left = std::min(int(A.rows()) - below, wanted);
  triangularize(A, below, rest, now.dim(), pivots);
  out.topRows(left) = A.block(below, rest, left, wanted);
  return out;
}

MatrixXd IncrementalQr::information(const std::vector<Key>& keys) const {
  const RowBlock T = triangle_of(keys);
  return T.transpose() * T;
}

MatrixXd IncrementalQr::covariance(const std::vector<Key>& keys) const {
  const RowBlock T = triangle_of(keys);
  const MatrixXd inverse =
      T.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(T.rows(), T.cols()));
  // The least singular value in columns of unit norm is no less than this.
  const double least = 1.0 / (unit_columns(T).cwiseInverse().asDiagonal() * inverse).norm();
  if (!(least >= kNullTolerance)) {
    const std::vector<NullDirection> undetermined = null_directions(T);
    if (!undetermined.empty()) {
      const Values now = front();
      Values wanted;
      for (const Key key : keys) wanted.insert_from(now, key);
      throw NumericalError("the data leave a direction undetermined: " +
                           describe(undetermined.front(), wanted));
    }
  }
  return inverse * inverse.transpose();
}

// A window's residuals r = R x + d follow the globals as R dx/dg, the nodes with them: its score is
// (R dx/dg)' r. Rows of eliminated nodes stay zero.
std::vector<BlockScore> IncrementalQr::scores(const std::vector<int>& block_of_window,
                                              int blocks) const {
  const auto outside = [blocks](int b) { return b < 0 || b >= blocks; };
  if (blocks < 0 || int(block_of_window.size()) < windows() ||
      std::ranges::any_of(block_of_window, outside)) {
    throw std::invalid_argument("scores() needs a block for each of the " +
                                std::to_string(windows()) + " windows, from 0 to below " +
                                std::to_string(blocks));
  }
  const int globals = anchors_.dim();
  std::vector<BlockScore> out(std::size_t(blocks),
                              {VectorXd::Zero(globals), MatrixXd::Zero(globals, globals)});
  for (const Chain& chain : chains_) {
    const std::vector<MatrixXd> nodes = chain.tree.follow_globals(globals);
    for (int leaf = 0; leaf < chain.tree.size(); ++leaf) {
      const CondensedTriangle t = chain.tree.leaf(leaf);
      MatrixXd X = MatrixXd::Zero(t.width(), globals);
      VectorXd x(t.width());
      X.topRows(t.last) = nodes[std::size_t(leaf)];
      x.head(t.last) = chain.tree.last_of(leaf);
      if (t.first > 0) {
        X.middleRows(t.last, t.first) = nodes[std::size_t(leaf) - 1];
        x.segment(t.last, t.first) = chain.tree.last_of(leaf - 1);
      }
      X.bottomRows(t.globals).leftCols(t.globals).setIdentity();
      x.tail(t.globals) = x_globals_.head(t.globals);
      const auto R = t.R.leftCols(t.width()).triangularView<Eigen::Upper>();
      const MatrixXd J = R * X;
      const VectorXd r = R * x + t.R.col(t.width());
      const int window = chain.windows[std::size_t(leaf)];
      BlockScore& block = out[std::size_t(block_of_window[std::size_t(window)])];
      block.score += J.transpose() * r;
      block.information += J.transpose() * J;
    }
  }
  return out;
}

GlobalColumns IncrementalQr::columns_of(Key global) const {
  const Values::Slot& s = anchors_.slot(global);
  return {s.tangent, s.type.tangent()};
}

std::vector<NullDirection> IncrementalQr::null_space() const {
  return null_directions(root_.R.leftCols(root_.globals));
}

}  // namespace magimu
