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
  const FactorsAtHand factors = s.at_hand(s.factors(window));
  const std::vector<int> order = s.touched(factors, s.factors(window));
  ends.first = s.dim(window.first);
  BorderedChain chain(ends.first + int(order.size()) + 1, s.layout.max_dim());
  BorderedRows rows(s.blocks.size(), s.layout, chain, window.first, order);
  for (const FactorAt f : s.sorted.of(window.first, window.first)) rows.add(factors, f, -1, -1);
  for (int node = window.first + 1; node <= window.last; ++node) {
    chain.push(s.dim(node));
    for (const FactorAt f : s.sorted.of(node, node)) rows.add(factors, f, node - 1, node);
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
// of window by window.
class LinkOfEnds {
 public:
  explicit LinkOfEnds(const WindowedSystem& s)
      : s_(s),
        all_(s.all_globals()),
        linked_(int(all_.size()) + 1, s.layout.max_dim()),
        apart_(int(all_.size()) + 1, s.layout.max_dim()),
        rows_(s.blocks.size(), s.layout, linked_, -1, all_) {}

  // Call for each window, in their order.
  void add(std::size_t w, const Ends& ends) {
    const int first = s_.windows[w].first;
    if (first < 0) return;
    append(apart_, ends, [] {});
    apart_.eliminate();
    const std::vector<FactorAt>& links = s_.sorted.links(int(w));
    const FactorsAtHand factors = s_.at_hand(links);
    append(linked_, ends, [&] {
      for (const FactorAt f : links) rows_.add(factors, f, before_, first);
    });
    count_ += s_.count_rows(links);
    before_ = s_.windows[w].last;
  }

  // Returns the least pivot.
  double finish(CondensedChain& out) {
    if (linked_.nodes() > 0) linked_.eliminate();
    rows_.finish();
    apart_.finish();
    out.linked = of_globals(linked_, all_);
    out.linked.rows = count_;
    add_to(out.linked, of_globals(apart_, all_), -1.0);
    for (const CondensedWindow& w : out.windows) add_to(out.linked, w);
    return linked_.least_pivot();
  }

 private:
  const WindowedSystem& s_;
  std::vector<int> all_;
  BorderedChain linked_, apart_;
  BorderedRows rows_;
  int before_ = -1, count_ = 0;
};

}  // namespace

double condense_information(const WindowedSystem& s, double enough, CondensedChain& out) {
  const std::size_t n = s.windows.size();
  out.windows.assign(n, {});
  LinkOfEnds link(s);
  double least = 1.0;
  // If one window loses too many digits, others do, too, and no more are computed. The first is
  // condensed alone, as a test.
  for (std::size_t begin = 0; begin < n;) {
    const std::size_t count = begin == 0 ? 1 : std::min(kWindowsAtOnce, n - begin);
    std::vector<Ends> ends(count);
    std::vector<double> pivot(count, 1.0);
    parallel::for_each(count, [&](std::size_t i) {
      CondensedWindow& own = out.windows[begin + i];
      own = nothing_about(s.layout.globals.size());
      const WindowedSystem::Window& window = s.windows[begin + i];
      if (window.first >= 0) pivot[i] = condense_window(s, window, ends[i], own);
    });
    least = std::min(least, *std::ranges::min_element(pivot));
    if (least < enough) return least;
    for (std::size_t i = 0; i < count; ++i) link.add(begin + i, ends[i]);
    begin += count;
  }
  return std::min(least, link.finish(out));
}

}  // namespace magimu
