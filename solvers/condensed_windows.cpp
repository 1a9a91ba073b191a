// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed_windows.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kTiny = 1e-12;  // of a node's diagonal: what keeps a free direction regular
constexpr int kGathered = 64;    // eliminated rows that are subtracted at once

// Where each column of the system belongs.
struct Layout {
  std::vector<int> node;      // of a column; -1: a global
  std::vector<int> position;  // within the node, or among the globals
  std::vector<int> dim;       // of a node
  std::vector<int> globals;   // their columns
};

Layout lay_out(const Values& values, const std::function<int(Key)>& node_of, std::size_t nodes) {
  Layout out{std::vector<int>(std::size_t(values.dim())),
             std::vector<int>(std::size_t(values.dim())),
             std::vector<int>(nodes, 0),
             {}};
  for (const Values::Slot& slot : values.slots()) {
    const int node = node_of(slot.key);
    for (int c = slot.tangent; c < slot.tangent + slot.type.tangent(); ++c) {
      out.node[std::size_t(c)] = node;
      if (node < 0) {
        out.position[std::size_t(c)] = int(out.globals.size());
        out.globals.push_back(c);
      } else {
        out.position[std::size_t(c)] = out.dim[std::size_t(node)]++;
      }
    }
  }
  return out;
}

// One row of the system: where it belongs.
struct RowSpan {
  int first = -1, last = -1;  // nodes
};

RowSpan span_of(const LinearSystem& system, const Layout& layout, int row) {
  RowSpan span;
  for (int e = system.row_start()[std::size_t(row)]; e < system.row_start()[std::size_t(row) + 1];
       ++e) {
    const int node = layout.node[std::size_t(system.column()[std::size_t(e)])];
    if (node < 0) continue;
    span.first = span.first < 0 ? node : std::min(span.first, node);
    span.last = std::max(span.last, node);
  }
  return span;
}

class Window {
 public:
  Window(const LinearSystem& system, const Layout& layout)
      : system_(system), layout_(layout), g_(int(layout.globals.size())) {
    out.information.setZero(g_, g_);
    out.score.setZero(g_);
  }

  CondensedWindow out;

  // rows_of: the rows whose last node is this, for each node from first to last.
  void eliminate(int first, int last, const std::vector<std::vector<int>>& rows_of) {
    RowVectors own(0, 0);
    for (int node = first; node <= last; ++node) {
      const int d = layout_.dim[std::size_t(node)];
      const int before = node > first ? layout_.dim[std::size_t(node) - 1] : 0;
      // [previous node | this node | globals | residual]
      MatrixXd A = MatrixXd::Zero(before + d, before + d);
      RowVectors B = RowVectors::Zero(before + d, g_ + 1);
      if (before > 0) {
        A.topLeftCorner(before, before) = diagonal_;
        B.topRows(before) = border_;
      }
      for (const int row : rows_of[std::size_t(node)]) add(row, node, before, A, B);
      if (before > 0) eliminate_first(before, A, B);
      diagonal_ = A.bottomRightCorner(d, d);
      border_ = B.bottomRows(d);
    }
    const int d = layout_.dim[std::size_t(last)];
    MatrixXd A = diagonal_;
    RowVectors B = border_;
    eliminate_first(d, A, B);
    subtract();
    out.information.triangularView<Eigen::StrictlyUpper>() = out.information.transpose();
  }

  // A row of globals alone, or those parts of any row.
  void add_globals(int row) {
    const double r = system_.residual()[row];
    ++out.rows;
    out.squares += r * r;
    global_.clear();
    for_entries(row, [&](int column, double value) {
      if (layout_.node[std::size_t(column)] < 0) {
        global_.push_back({layout_.position[std::size_t(column)], value});
      }
    });
    for (const auto& [i, x] : global_) {
      if (x == 0.0) continue;
      out.score[i] -= x * r;
      for (const auto& [j, y] : global_) {
        if (j <= i) out.information(i, j) += x * y;
      }
    }
  }

 private:
  using RowVectors = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  template <class Body>
  void for_entries(int row, const Body& body) const {
    for (int e = system_.row_start()[std::size_t(row)];
         e < system_.row_start()[std::size_t(row) + 1]; ++e) {
      body(system_.column()[std::size_t(e)], system_.value()[std::size_t(e)]);
    }
  }

  void add(int row, int node, int before, MatrixXd& A, RowVectors& B) {
    add_globals(row);
    local_.clear();
    for_entries(row, [&](int column, double value) {
      const int n = layout_.node[std::size_t(column)];
      if (n < 0 || value == 0.0) return;
      local_.push_back({(n == node ? before : 0) + layout_.position[std::size_t(column)], value});
    });
    const double r = system_.residual()[row];
    for (const auto& [i, x] : local_) {
      for (const auto& [j, y] : local_) A(i, j) += x * y;
      for (const auto& [j, y] : global_) B(i, j) += x * y;
      B(i, g_) += x * r;
    }
  }

  // Eliminates the first n unknowns of A, with their border.
  void eliminate_first(int n, MatrixXd& A, RowVectors& B) {
    MatrixXd own = A.topLeftCorner(n, n);
    own.diagonal() *= 1.0 + kTiny;
    own.diagonal().array() += 1e-30;
    const Eigen::LLT<MatrixXd> llt(own);
    out.log_det += 2.0 * llt.matrixLLT().diagonal().array().log().sum();
    RowVectors panel = B.topRows(n);
    llt.matrixL().solveInPlace(panel);
    const Eigen::Index rest = A.rows() - n;
    if (rest > 0) {
      MatrixXd W = A.topRightCorner(n, rest);
      llt.matrixL().solveInPlace(W);
      A.bottomRightCorner(rest, rest) -= W.transpose() * W;
      B.bottomRows(rest) -= W.transpose() * panel;
    }
    if (gathered_.rows() == 0) gathered_.resize(kGathered + 64, g_ + 1);
    if (filled_ + n > kGathered) subtract();
    gathered_.middleRows(filled_, n) = panel;
    filled_ += n;
  }

  // What elimination has gathered leaves the globals' block, many rows at once.
  void subtract() {
    const auto rows = gathered_.topRows(filled_);
    out.information.selfadjointView<Eigen::Lower>().rankUpdate(rows.leftCols(g_).transpose(), -1.0);
    out.score += rows.leftCols(g_).transpose() * rows.col(g_);
    out.squares -= rows.col(g_).squaredNorm();
    filled_ = 0;
  }

  const LinearSystem& system_;
  const Layout& layout_;
  int g_;
  MatrixXd diagonal_;
  RowVectors border_, gathered_;
  Eigen::Index filled_ = 0;
  std::vector<std::pair<int, double>> local_, global_;
};

}  // namespace

int CondensedChain::position(const Values& values, Key key) const {
  const int column = values.slot(key).tangent;
  return int(std::lower_bound(columns.begin(), columns.end(), column) - columns.begin());
}

CondensedWindow CondensedChain::sum(int without) const {
  CondensedWindow out = priors;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (int(w) == without) continue;
    out.information += windows[w].information;
    out.score += windows[w].score;
    out.squares += windows[w].squares;
    out.log_det += windows[w].log_det;
    out.rows += windows[w].rows;
  }
  return out;
}

CondensedChain condense(const LinearSystem& system, const Values& values,
                        const std::function<int(Key)>& node_of, const std::vector<int>& window_of) {
  const Layout layout = lay_out(values, node_of, window_of.size());
  const int windows =
      window_of.empty() ? 0 : *std::max_element(window_of.begin(), window_of.end()) + 1;
  std::vector<std::vector<int>> rows_of(window_of.size());
  Window priors(system, layout);
  for (int row = 0; row < system.rows(); ++row) {
    const RowSpan span = span_of(system, layout, row);
    if (span.first < 0) {
      priors.add_globals(row);
    } else if (window_of[std::size_t(span.first)] == window_of[std::size_t(span.last)]) {
      rows_of[std::size_t(span.last)].push_back(row);
    }
  }
  priors.out.information.triangularView<Eigen::StrictlyUpper>() =
      priors.out.information.transpose();
  CondensedChain out;
  out.columns = layout.globals;
  out.priors = std::move(priors.out);
  out.windows.resize(std::size_t(windows));
  tbb::parallel_for(0, windows, [&](int w) {
    const auto begin = std::find(window_of.begin(), window_of.end(), w);
    auto end = begin;
    while (end != window_of.end() && *end == w) ++end;
    Window window(system, layout);
    if (begin != end) {
      window.eliminate(int(begin - window_of.begin()), int(end - window_of.begin()) - 1, rows_of);
    }
    out.windows[std::size_t(w)] = std::move(window.out);
  });
  return out;
}

}  // namespace magimu
