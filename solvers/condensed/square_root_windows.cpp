// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed/square_root_windows.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "graph/parallel.h"
#include "solvers/kernels/row_chain.h"

namespace magimu {
namespace {

constexpr int kGatheredRows = 96;    // reduced to a triangle at a time
constexpr double kWeakPrior = 1e-7;  // of a column's norm

using Window = WindowedSystem::Window;

// A window's information on its two end nodes and the globals it touches, as a triangle.
struct EndRows {
  std::vector<int> globals;
  RowBlock rows;         // [last | first | globals | residual]; no `last` in a window of one node
  double log_det = 0.0;  // of the nodes between
  CondensedWindow rest;  // information on the globals alone, whatever the ends are
};

// Writes factors' rows over [up to three nodes | globals | residual].
class RowWriter {
 public:
  RowWriter(const WindowedSystem& s, const std::vector<int>& globals)
      : s_(s), place_(s.layout.globals.size(), -1), globals_(int(globals.size())) {
    for (int i = 0; i < globals_; ++i) place_[std::size_t(globals[std::size_t(i)])] = i;
  }

  // nodes: -1 for none. Returns the row after the last one written.
  int write(const FactorsAtHand& at_hand, std::span<const FactorAt> factors,
            const std::array<int, 3>& nodes, RowStack& A, int row) const {
    const int globals_at = A.columns() - 1 - globals_;
    for (const FactorAt at : factors) {
      const FactorRows f = at_hand.rows(at);
      for (int e = 0; e < f.columns; ++e) {
        const int to = column_of(std::size_t(f.column[e]), nodes, globals_at);
        if (to < 0) continue;
        for (int r = 0; r < f.rows; ++r) A.row(row + r)[to] = f.value[r * f.columns + e];
      }
      for (int r = 0; r < f.rows; ++r) A.row(row + r)[A.columns() - 1] = f.residual[r];
      row += f.rows;
    }
    return row;
  }

 private:
  int column_of(std::size_t column, const std::array<int, 3>& nodes, int globals_at) const {
    const int node = s_.layout.node[column], position = s_.layout.position[column];
    if (node < 0) {
      const int place = place_[std::size_t(position)];
      return place < 0 ? -1 : globals_at + place;
    }
    int at = 0;
    for (const int n : nodes) {
      if (n == node) return at + position;
      at += s_.dim(n);
    }
    return -1;
  }

  const WindowedSystem& s_;
  std::vector<int> place_;  // of each global of the system among the given ones; -1: not given
  int globals_;
};

// Rows over [first | globals | residual] that inner nodes leave behind. As soon as kGatheredRows
// are there they are reduced to a triangle on the first node; the other rows go to a sum of
// squares.
class LeftRows {
 public:
  LeftRows(int first, int globals) : first_(first), sum_(globals + 1) {
    rows_.reset(kGatheredRows, first + globals + 1);
  }

  // Rows begin <= i < end of A, whose last columns are [first | globals | residual].
  void push(const RowStack& A, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (filled_ == rows_.rows()) condense();
      std::copy_n(A.row(i) + A.columns() - rows_.columns(), rows_.columns(), rows_.row(filled_++));
    }
  }
  int size() const { return filled_; }
  const RowStack& rows() const { return rows_; }
  SquareSum& sum() { return sum_; }

 private:
  void condense() {
    std::vector<int> pivots;
    const int below = triangularize(rows_, 0, 0, first_, pivots);
    add_rows(rows_, below, filled_, first_, sum_);
    std::fill(rows_.row(below), rows_.row(filled_ - 1) + rows_.columns(), 0.0);
    filled_ = below;
  }

  int first_, filled_ = 0;
  RowStack rows_;
  SquareSum sum_;
};

// Into A from row `at` and this column on.
void copy_rows(const RowBlock& from, RowStack& A, int at, int column) {
  for (Eigen::Index i = 0; i < from.rows(); ++i) {
    std::copy_n(from.row(i).data(), from.cols(), A.row(at + int(i)) + column);
  }
}

// The window by itself, both end nodes eliminated. A window that barely constrains its first node
// (a hand's position and velocity) leaves near-zero pivots there. Rounding in those pivots would
// look like information, and would take a random part of the residuals with it. A weak prior at the
// node's present value keeps them out.
// of_last: rows of the last node's pivots.
CondensedWindow by_itself(const WindowedSystem& s, const EndRows& ends, int first, int of_last) {
  const int columns = int(ends.rows.cols()), there = int(ends.rows.rows());
  const int ends_columns = columns - 1 - int(ends.globals.size());
  RowStack A(there + first, columns);
  copy_rows(ends.rows, A, 0, 0);
  for (int j = 0; j < first; ++j) {
    const int column = ends_columns - first + j;
    A.row(there + j)[column] = kWeakPrior * ends.rows.col(column).tail(there - of_last).norm();
  }
  std::vector<int> pivots;
  const int below = triangularize(A, 0, 0, ends_columns, pivots);
  SquareSum sum(columns - ends_columns);
  add_rows(A, below, A.rows(), ends_columns, sum);
  sum.finish();
  CondensedWindow out = condensed(sum, 0, ends.globals, s.layout.globals.size());
  add_to(out, ends.rest);
  return out;
}

// Inner nodes are eliminated one after the other, each from the few rows that touch it: those left
// by the elimination of the node before (carried), its own, and those it shares with the next.
CondensedWindow condense_window(const WindowedSystem& s, const Window& window, EndRows& ends) {
  const auto [first, last] = window;
  const FactorsAtHand factors = s.at_hand(s.factors(window));
  ends.globals = s.touched(factors, s.factors(window));
  const RowWriter writer(s, ends.globals);
  const int edge = s.dim(first), border = edge + int(ends.globals.size()) + 1;
  LeftRows left(edge, int(ends.globals.size()));
  thread_local RowChain chain;
  chain.reset(border);
  {
    const auto own = s.sorted.own(first);
    RowStack A(s.count_rows(own), border);
    left.push(A, 0, writer.write(factors, own, {first, -1, -1}, A, 0));
  }
  for (int node = first + 1; node <= last; ++node) {
    // Factors of the first node alone were gathered above.
    const int before = node - 1 > first ? node - 1 : -1;
    const std::array<int, 3> nodes = {before, node, first};
    const auto own = before < 0 ? std::span<const FactorAt>() : s.sorted.own(before);
    const auto across = s.sorted.across(node);
    RowStack& A = chain.stack(s.dim(before), s.dim(node), s.count_rows(own) + s.count_rows(across));
    writer.write(factors, across, nodes, A,
                 writer.write(factors, own, nodes, A, chain.first_row()));
    chain.eliminate();
    ends.log_det += chain.log_det();
    left.push(A, chain.end_of_next(), A.rows());
  }
  const std::array<int, 3> nodes = {last > first ? last : -1, -1, first};
  const auto own = last > first ? s.sorted.own(last) : std::span<const FactorAt>();
  const int gathered = left.size();
  RowStack& A = chain.stack(s.dim(nodes[0]), 0, s.count_rows(own) + gathered);
  const int rows = writer.write(factors, own, nodes, A, chain.first_row());
  for (int i = 0; i < gathered; ++i) {
    std::copy_n(left.rows().row(i), border, A.row(rows + i) + A.columns() - border);
  }
  std::vector<int> pivots;
  const int ends_columns = A.columns() - border + edge;
  const int below = triangularize(A, 0, 0, ends_columns, pivots);
  ends.rows = A.view().topRows(below);
  add_rows(A, below, A.rows(), ends_columns, left.sum());
  left.sum().finish();
  ends.rest = condensed(left.sum(), 0, ends.globals, s.layout.globals.size());
  const auto of_last =
      std::count_if(pivots.begin(), pivots.end() - edge, [](int p) { return p >= 0; });
  CondensedWindow out = by_itself(s, ends, edge, int(of_last));
  out.log_det = ends.log_det + log_det_of_pivots(A, 0, pivots);
  out.rows = s.count_rows(s.factors(window));
  return out;
}

// A window's ends into rows over [before | first | last | all globals | residual].
void copy_ends(const EndRows& ends, int before, int first, int last, RowStack& A, int at) {
  const int globals_at = before + first + last;
  for (Eigen::Index i = 0; i < ends.rows.rows(); ++i) {
    const double* const from = ends.rows.row(i).data();
    double* const to = A.row(at + int(i));
    std::copy_n(from, last, to + before + first);
    std::copy_n(from + last, first, to + before);
    const double* const globals = from + last + first;
    for (std::size_t g = 0; g < ends.globals.size(); ++g) {
      to[globals_at + ends.globals[g]] = globals[g];
    }
    to[A.columns() - 1] = globals[ends.globals.size()];
  }
}

// Eliminates the windows' end nodes along the chain, with the factors that link two windows. A
// window's information on the globals alone (`rest`) is added as it is.
class LinkOfRows {
 public:
  explicit LinkOfRows(const WindowedSystem& s)
      : s_(s),
        all_(s.all_globals()),
        writer_(s, all_),
        sum_(int(all_.size()) + 1),
        chain_(sum_.columns()),
        out_(nothing_about(all_.size())) {}

  // Call for each window, in their order. rows: number of residuals of the window.
  void add(std::size_t w, const EndRows& ends, int rows) {
    const int first = s_.windows[w].first;
    if (first < 0) return;
    const int last = s_.windows[w].last > first ? s_.windows[w].last : -1;
    const std::array<int, 3> nodes = {before_, first, last};  // last = -1 in a window of one node
    const std::vector<FactorAt>& factors = s_.sorted.links(int(w));
    const int between = s_.count_rows(factors);
    const int gone = s_.dim(before_) + (last < 0 ? 0 : s_.dim(first));
    const int kept = last < 0 ? s_.dim(first) : s_.dim(last);
    RowStack& A = chain_.stack(gone, kept, between + int(ends.rows.rows()));
    copy_ends(ends, s_.dim(before_), s_.dim(first), s_.dim(last), A,
              writer_.write(s_.at_hand(factors), factors, nodes, A, chain_.first_row()));
    chain_.eliminate();
    out_.log_det += ends.log_det + chain_.log_det();
    log_det_carried_ = chain_.log_det_of_next();
    add_rows(A, chain_.end_of_next(), A.rows(), gone + kept, sum_);
    before_ = s_.windows[w].last;
    add_to(out_, ends.rest);
    out_.rows += rows + between;
  }

  CondensedWindow finish() {
    sum_.finish();
    add_to(out_, condensed(sum_, 0, all_, all_.size()));
    out_.log_det += log_det_carried_;
    return std::move(out_);
  }

 private:
  const WindowedSystem& s_;
  std::vector<int> all_;
  RowWriter writer_;
  SquareSum sum_;
  RowChain chain_;
  CondensedWindow out_;
  double log_det_carried_ = 0.0;
  int before_ = -1;
};

}  // namespace

void condense_square_root(const WindowedSystem& s, CondensedChain& out) {
  const std::size_t n = s.windows.size();
  out.windows.assign(n, {});
  LinkOfRows link(s);
  for (std::size_t begin = 0; begin < n; begin += kWindowsAtOnce) {
    const std::size_t count = std::min(kWindowsAtOnce, n - begin);
    std::vector<EndRows> ends(count);
    parallel::for_each(count, [&](std::size_t i) {
      const Window& window = s.windows[begin + i];
      out.windows[begin + i] = window.first < 0 ? nothing_about(s.layout.globals.size())
                                                : condense_window(s, window, ends[i]);
    });
    for (std::size_t i = 0; i < count; ++i) {
      link.add(begin + i, ends[i], out.windows[begin + i].rows);
    }
  }
  out.linked = link.finish();
}

}  // namespace magimu
