// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed/information_windows.h"

#include <algorithm>

#include "graph/parallel.h"
#include "solvers/condensed/bordered_rows.h"

namespace magimu {
namespace {

// A window's information on its two end nodes and the globals.
struct Ends {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  int first = 0, last = 0;  // their unknowns, counted once
  MatrixXd information;     // [first | last], upper triangle
  VectorXd taken;           // of its diagonal, by elimination
  Rows rows;                // [first | last] x [globals | residual]
};

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

// The first node stays in the border until all between it and the last are eliminated. Returns the
// least pivot.
double condense_window(const WindowedSystem& s, const WindowedSystem::Window& window, Ends& ends,
                       CondensedWindow& out) {
  const std::vector<int> order = s.touched(s.factors(window));
  ends.first = s.dim(window.first);
  BorderedChain chain(ends.first + int(order.size()) + 1, s.layout.max_dim());
  BorderedRows rows(s.system, s.layout, chain, window.first, order);
  for (const FactorAt f : s.sorted.of(window.first, window.first)) rows.add(f, -1, -1);
  for (int node = window.first + 1; node <= window.last; ++node) {
    chain.push(s.dim(node));
    for (const FactorAt f : s.sorted.of(node, node)) rows.add(f, node - 1, node);
    if (chain.nodes() == 2) chain.eliminate();
  }
  rows.finish();
  ends.last = chain.unknowns();
  chain.pull(rows.edge_diagonal());
  take_ends(chain, order, s.layout.globals.size(), ends);
  while (chain.nodes() > 0) chain.eliminate();
  chain.finish();
  out = condensed(chain.border(), ends.first, order, s.layout.globals.size());
  out.log_det = chain.log_det();
  out.rows = s.count_rows(s.factors(window));
  return chain.least_pivot();
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
  if (ends.last == 0) return;
  chain.push(ends.last);
  add_end(chain, ends, ends.first, ends.last, chain.older());
  for (int i = 0; i < ends.first; ++i) {
    for (int j = 0; j < ends.last; ++j) {
      chain.information(i, chain.older() + j) += ends.information(i, ends.first + j);
    }
  }
  chain.eliminate();
}

CondensedWindow of_globals(const BorderedChain& chain, const std::vector<int>& all) {
  CondensedWindow out = condensed(chain.border(), 0, all, all.size());
  out.log_det = chain.log_det();
  return out;
}

// The windows' sum with the factors that link them: their ends are eliminated in one chain instead
// of window by window. Returns the least pivot.
double link(const WindowedSystem& s, const std::vector<Ends>& ends, CondensedChain& out) {
  const std::vector<int> all = s.all_globals();
  const int border = int(all.size()) + 1, dim = s.layout.max_dim();
  BorderedChain linked(border, dim), apart(border, dim);
  BorderedRows rows(s.system, s.layout, linked, -1, all);
  int before = -1, links = 0;
  for (std::size_t w = 0; w < s.windows.size(); ++w) {
    const int first = s.windows[w].first;
    if (first < 0) continue;
    append(apart, ends[w], [] {});
    apart.eliminate();
    append(linked, ends[w], [&] {
      for (const FactorAt f : s.sorted.links(int(w))) rows.add(f, before, first);
    });
    links += s.count_rows(s.sorted.links(int(w)));
    before = s.windows[w].last;
  }
  if (linked.nodes() > 0) linked.eliminate();
  rows.finish();
  apart.finish();
  out.linked = of_globals(linked, all);
  out.linked.rows = links;
  add_to(out.linked, of_globals(apart, all), -1.0);
  for (const CondensedWindow& w : out.windows) add_to(out.linked, w);
  return linked.least_pivot();
}

}  // namespace

double condense_information(const WindowedSystem& s, double enough, CondensedChain& out) {
  std::vector<Ends> ends(s.windows.size());
  std::vector<double> pivot(s.windows.size(), 1.0);
  out.windows.assign(s.windows.size(), nothing_about(s.layout.globals.size()));
  const auto condense_one = [&](std::size_t w) {
    if (s.windows[w].first < 0) return;
    pivot[w] = condense_window(s, s.windows[w], ends[w], out.windows[w]);
  };
  // If one window loses too many digits, others do, too: no more are computed.
  if (!s.windows.empty()) condense_one(0);
  if (s.windows.empty() || pivot.front() >= enough) {
    parallel::for_each(std::max<std::size_t>(1, s.windows.size()) - 1,
                       [&](std::size_t w) { condense_one(w + 1); });
  }
  const double least = pivot.empty() ? 1.0 : *std::min_element(pivot.begin(), pivot.end());
  return least < enough ? least : std::min(least, link(s, ends, out));
}

}  // namespace magimu
