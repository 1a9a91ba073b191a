// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed/bordered_rows.h"

#include <algorithm>
#include <utility>

namespace magimu {

BorderedRows::BorderedRows(std::size_t blocks, const ColumnLayout& layout, BorderedChain& chain,
                           int edge, const std::vector<int>& globals)
    : layout_(layout),
      chain_(chain),
      edge_(edge),
      edge_diagonal_(edge < 0 ? 0 : std::size_t(layout.dim[std::size_t(edge)]), 0.0),
      place_(layout.globals.size(), -1),
      groups_(blocks) {
  int next = int(edge_diagonal_.size());
  for (const int global : globals) place_[std::size_t(global)] = next++;
}

void BorderedRows::add(const FactorsAtHand& factors, FactorAt at, int older, int newer) {
  const FactorRows factor = factors.rows(at);
  sort_entries(factor, older, newer);
  Group& group = groups_[std::size_t(at.block)];
  if (!has_these(group, factor)) {
    close(group);
    open(group, factor);
  }
  add_within_border(group, factor);
  add_to_nodes(group, factor);
}

void BorderedRows::finish() {
  for (Group& group : groups_) close(group);
  chain_.finish();
}

void BorderedRows::sort_entries(const FactorRows& factor, int older, int newer) {
  of_nodes_.clear();
  of_edge_.clear();
  of_globals_.clear();
  for (int e = 0; e < factor.columns; ++e) {
    const auto column = std::size_t(factor.column[e]);
    const int node = layout_.node[column], position = layout_.position[column];
    if (node < 0) {
      if (place_[std::size_t(position)] >= 0) of_globals_.push_back(e);
    } else if (node == edge_) {
      of_edge_.push_back({e, position});
    } else if (node == newer) {
      of_nodes_.push_back({e, chain_.older() + position});
    } else if (node == older) {
      of_nodes_.push_back({e, position});
    }
  }
}

bool BorderedRows::has_these(const Group& group, const FactorRows& factor) const {
  if (!group.squares || group.entries != of_globals_) return false;
  for (std::size_t i = 0; i < group.entries.size(); ++i) {
    if (factor.column[group.entries[i]] != group.columns[i]) return false;
  }
  return true;
}

void BorderedRows::open(Group& group, const FactorRows& factor) const {
  group.entries = of_globals_;
  for (std::size_t i = 0; i < group.entries.size(); ++i) {
    const int from = group.entries[i], column = factor.column[from];
    const int to = place_[std::size_t(layout_.position[std::size_t(column)])];
    group.columns.push_back(column);
    const Run* last = group.runs.empty() ? nullptr : &group.runs.back();
    if (last != nullptr && from - last->from == last->count && to - last->to == last->count) {
      ++group.runs.back().count;
    } else {
      group.runs.push_back({from, int(i), to, 1});
    }
  }
  group.squares.emplace(int(group.entries.size()) + 1);
}

// What the group has gathered goes to the border.
void BorderedRows::close(Group& group) {
  if (!group.squares) return;
  SquareSum& own = *group.squares;
  own.finish();
  std::vector<int> to;
  for (const Run& run : group.runs) {
    for (int k = 0; k < run.count; ++k) to.push_back(run.to + k);
  }
  to.push_back(chain_.border().columns() - 1);
  for (int i = 0; i < own.columns(); ++i) {
    for (int j = i; j < own.columns(); ++j) {
      const auto [a, b] = std::minmax(to[std::size_t(i)], to[std::size_t(j)]);
      chain_.border()(a, b) += std::as_const(own)(i, j);
    }
  }
  group = {};
}

void BorderedRows::add_within_border(Group& group, const FactorRows& factor) {
  SquareSum& sum = of_edge_.empty() ? *group.squares : chain_.border();
  double* row = sum.rows(factor.rows);
  for (int r = 0; r < factor.rows; ++r, row += sum.width()) {
    const double* const value = factor.value + r * factor.columns;
    for (const Entry& e : of_edge_) {
      row[e.to] = value[e.from];
      edge_diagonal_[std::size_t(e.to)] += value[e.from] * value[e.from];
    }
    for (const Run& run : group.runs) {
      std::copy_n(value + run.from, run.count, row + (of_edge_.empty() ? run.at : run.to));
    }
    row[sum.columns() - 1] = factor.residual[r];
  }
}

void BorderedRows::add_to_nodes(const Group& group, const FactorRows& factor) {
  const int last = chain_.border().columns() - 1;
  for (const Entry& i : of_nodes_) {
    double* const border = chain_.row(i.to);
    for (int r = 0; r < factor.rows; ++r) {
      const double* const value = factor.value + r * factor.columns;
      const double x = value[i.from];
      if (x == 0.0) continue;
      for (const Entry& j : of_nodes_) {
        if (j.to >= i.to) chain_.information(i.to, j.to) += x * value[j.from];
      }
      for (const Entry& e : of_edge_) border[e.to] += x * value[e.from];
      for (const Run& run : group.runs) {
        Eigen::Map<VectorXd>(border + run.to, run.count) +=
            x * Eigen::Map<const VectorXd>(value + run.from, run.count);
      }
      border[last] += x * factor.residual[r];
    }
  }
}

}  // namespace magimu
