// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed_windows.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "solvers/bordered_rows.h"

namespace magimu {
namespace {

// What a window says of its two ends and the globals.
struct Ends {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  int first_node = -1, last_node = -1;  // the same where it has but one; -1: none
  int first = 0, last = 0;              // their unknowns, counted once
  MatrixXd information;                 // [first | last], upper triangle
  VectorXd taken;                       // of its diagonal, by elimination
  Rows rows;                            // [first | last] x [globals | residual]
};

// The globals that a window's factors touch, in the order in which they appear: those of one kind
// of factor lie side by side.
std::vector<int> touched(const LinearSystem& system, const ColumnLayout& layout,
                         std::span<const FactorAt> factors) {
  std::vector<int> out;
  std::vector<char> seen(layout.globals.size(), 0);
  for (const FactorAt f : factors) {
    const FactorRows rows = rows_of(system, f);
    for (int e = 0; e < rows.columns; ++e) {
      const auto c = std::size_t(rows.column[e]);
      if (layout.node[c] >= 0 || seen[std::size_t(layout.position[c])] != 0) continue;
      for (int r = 0; r < rows.rows; ++r) {
        if (rows.value[r * rows.columns + e] == 0.0) continue;
        seen[std::size_t(layout.position[c])] = 1;
        out.push_back(layout.position[c]);
        break;
      }
    }
  }
  return out;
}

CondensedWindow nothing(std::size_t globals) {
  const auto g = Eigen::Index(globals);
  CondensedWindow out;
  out.information.setZero(g, g);
  out.score.setZero(g);
  return out;
}

// Columns `skip` and on of a finished border: order are their globals, a residual comes last.
CondensedWindow condensed(const SquareSum& border, int skip, const std::vector<int>& order,
                          std::size_t globals) {
  CondensedWindow out = nothing(globals);
  const int last = border.columns() - 1;
  for (int i = skip; i < last; ++i) {
    const int a = order[std::size_t(i - skip)];
    for (int j = i; j < last; ++j) {
      const int b = order[std::size_t(j - skip)];
      out.information(a, b) = out.information(b, a) = border(i, j);
    }
    out.score[a] = -border(i, last);
  }
  out.squares = border(last, last);
  return out;
}

int count_rows(const LinearSystem& system, std::span<const FactorAt> factors) {
  int rows = 0;
  for (const FactorAt f : factors) rows += rows_of(system, f).rows;
  return rows;
}

// The nodes that are left of a window, the first one and the last. order: the border's globals
// beyond the first node's own columns.
void take_ends(BorderedChain& chain, const std::vector<int>& order, std::size_t globals,
               Ends& out) {
  const int n = chain.unknowns();
  out.information.setZero(n, n);
  out.taken.resize(n);
  out.rows.setZero(n, Eigen::Index(globals) + 1);
  for (int i = 0; i < n; ++i) {
    out.taken[i] = chain.taken(i);
    for (int j = i; j < n; ++j) out.information(i, j) = chain.information(i, j);
    const double* const row = chain.row(i) + out.first;
    for (std::size_t k = 0; k < order.size(); ++k) out.rows(i, order[k]) = row[k];
    out.rows(i, out.rows.cols() - 1) = row[order.size()];
  }
}

// The first node stays in the border until all between it and the last are eliminated.
CondensedWindow condense_window(const LinearSystem& system, const ColumnLayout& layout,
                                const SortedFactors& sorted, Ends& ends) {
  const int first = ends.first_node, last = ends.last_node;
  const std::span<const FactorAt> factors = sorted.of(first, last);
  const std::vector<int> order = touched(system, layout, factors);
  ends.first = layout.dim[std::size_t(first)];
  BorderedChain chain(ends.first + int(order.size()) + 1, layout.max_dim());
  BorderedRows rows(system, layout, chain, first, order);
  for (const FactorAt f : sorted.of(first, first)) rows.add(f, -1, -1);
  for (int node = first + 1; node <= last; ++node) {
    chain.push(layout.dim[std::size_t(node)]);
    for (const FactorAt f : sorted.of(node, node)) rows.add(f, node - 1, node);
    if (chain.nodes() == 2) chain.eliminate();
  }
  rows.finish();
  ends.last = chain.unknowns();
  chain.pull(rows.edge_diagonal());
  take_ends(chain, order, layout.globals.size(), ends);
  while (chain.nodes() > 0) chain.eliminate();
  chain.finish();
  CondensedWindow out = condensed(chain.border(), ends.first, order, layout.globals.size());
  out.log_det = chain.log_det();
  out.rows = count_rows(system, factors);
  return out;
}

// Some of the ends' unknowns take their place in a chain.
void add_end(BorderedChain& chain, const Ends& ends, int begin, int count, int at) {
  for (int i = 0; i < count; ++i) {
    chain.taken(at + i) += ends.taken[begin + i];
    for (int j = i; j < count; ++j) {
      chain.information(at + i, at + j) += ends.information(begin + i, begin + j);
    }
    Eigen::Map<Eigen::RowVectorXd>(chain.row(at + i), ends.rows.cols()) += ends.rows.row(begin + i);
  }
}

// A window's ends follow what is left of the windows before, linked to it or not.
template <class AddLinks>
void append(BorderedChain& chain, const Ends& ends, const AddLinks& add_links) {
  chain.push(ends.first);
  add_end(chain, ends, 0, ends.first, chain.older());
  add_links();
  if (chain.nodes() == 2) chain.eliminate();
  if (ends.first_node == ends.last_node) return;
  chain.push(ends.last);
  add_end(chain, ends, ends.first, ends.last, chain.older());
  for (int i = 0; i < ends.first; ++i) {
    for (int j = 0; j < ends.last; ++j) {
      chain.information(i, chain.older() + j) += ends.information(i, ends.first + j);
    }
  }
  chain.eliminate();
}

void add_to(CondensedWindow& sum, const CondensedWindow& w, double sign = 1.0) {
  sum.information += sign * w.information;
  sum.score += sign * w.score;
  sum.squares += sign * w.squares;
  sum.log_det += sign * w.log_det;
  sum.rows += w.rows;
}

CondensedWindow of_globals(const BorderedChain& chain, const std::vector<int>& all) {
  CondensedWindow out = condensed(chain.border(), 0, all, all.size());
  out.log_det = chain.log_det();
  return out;
}

// The windows' sum with the factors that link them: their ends are eliminated in one chain instead
// of window by window.
CondensedWindow link(const LinearSystem& system, const ColumnLayout& layout,
                     const SortedFactors& sorted, const std::vector<Ends>& ends,
                     const std::vector<CondensedWindow>& windows) {
  std::vector<int> all(layout.globals.size());
  std::iota(all.begin(), all.end(), 0);
  const int border = int(all.size()) + 1, dim = layout.max_dim();
  BorderedChain linked(border, dim), apart(border, dim);
  BorderedRows rows(system, layout, linked, -1, all);
  int before = -1, links = 0;
  for (int w = 0; w < sorted.windows(); ++w) {
    const Ends& e = ends[std::size_t(w)];
    if (e.first_node < 0) continue;
    append(apart, e, [] {});
    apart.eliminate();
    append(linked, e, [&] {
      for (const FactorAt f : sorted.links(w)) rows.add(f, before, e.first_node);
    });
    links += count_rows(system, sorted.links(w));
    before = e.last_node;
  }
  if (linked.nodes() > 0) linked.eliminate();
  rows.finish();
  apart.finish();
  CondensedWindow out = of_globals(linked, all);
  out.rows = links;
  add_to(out, of_globals(apart, all), -1.0);
  for (const CondensedWindow& w : windows) add_to(out, w);
  return out;
}

CondensedWindow condense_priors(const LinearSystem& system, const ColumnLayout& layout,
                                const SortedFactors& sorted) {
  std::vector<int> all(layout.globals.size());
  std::iota(all.begin(), all.end(), 0);
  BorderedChain none(int(all.size()) + 1, 0);
  BorderedRows rows(system, layout, none, -1, all);
  for (const FactorAt f : sorted.priors()) rows.add(f, -1, -1);
  rows.finish();
  CondensedWindow out = of_globals(none, all);
  out.rows = count_rows(system, sorted.priors());
  return out;
}

}  // namespace

int CondensedChain::position(const Values& values, Key key) const {
  const int column = values.slot(key).tangent;
  return int(std::lower_bound(columns.begin(), columns.end(), column) - columns.begin());
}

CondensedWindow CondensedChain::sum(int without) const {
  CondensedWindow out = priors;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (int(w) != without) add_to(out, windows[w]);
  }
  return out;
}

CondensedWindow CondensedChain::whole() const {
  CondensedWindow out = priors;
  add_to(out, linked);
  return out;
}

CondensedChain condense(const LinearSystem& system, const Values& values,
                        const std::function<int(Key)>& node_of, const std::vector<int>& window_of) {
  const ColumnLayout layout(values, node_of, window_of.size());
  const SortedFactors sorted(system, layout, window_of);
  std::vector<Ends> ends(std::size_t(sorted.windows()));
  for (int node = 0; node < int(window_of.size()); ++node) {
    const int w = window_of[std::size_t(node)];
    if (w < 0) continue;
    Ends& own = ends[std::size_t(w)];
    if (own.first_node < 0) own.first_node = node;
    own.last_node = node;
  }
  CondensedChain out;
  out.columns = layout.globals;
  out.priors = condense_priors(system, layout, sorted);
  out.windows.resize(ends.size());
  tbb::parallel_for(std::size_t(0), ends.size(), [&](std::size_t w) {
    out.windows[w] = ends[w].first_node < 0 ? nothing(layout.globals.size())
                                            : condense_window(system, layout, sorted, ends[w]);
  });
  out.linked = link(system, layout, sorted, ends, out.windows);
  return out;
}

}  // namespace magimu
