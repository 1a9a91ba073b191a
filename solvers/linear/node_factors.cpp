// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/linear/node_factors.h"

#include <algorithm>

namespace magimu {
namespace {

// The first and the last node that a factor touches; -1: none.
struct Span {
  int first = -1, last = -1;
};

Span span_of(std::span<const int> columns, const ColumnLayout& layout) {
  Span span;
  for (const int c : columns) {
    const int node = layout.node[std::size_t(c)];
    if (node < 0) continue;
    span.first = span.first < 0 ? node : std::min(span.first, node);
    span.last = std::max(span.last, node);
  }
  return span;
}

}  // namespace

ColumnLayout::ColumnLayout(const Values& values, const std::function<int(Key)>& node_of,
                           std::size_t nodes)
    : node(std::size_t(values.dim())), position(std::size_t(values.dim())), dim(nodes, 0) {
  for (const Values::Slot& slot : values.slots()) {
    const int own = node_of(slot.key);
    for (int c = slot.tangent; c < slot.tangent + slot.type.tangent(); ++c) {
      node[std::size_t(c)] = own;
      if (own < 0) {
        position[std::size_t(c)] = int(globals.size());
        globals.push_back(c);
      } else {
        position[std::size_t(c)] = dim[std::size_t(own)]++;
      }
    }
  }
}

int ColumnLayout::max_dim() const {
  return dim.empty() ? 0 : *std::max_element(dim.begin(), dim.end());
}

FactorRows rows_of(const LinearSystem& system, FactorAt factor) {
  const LinearSystem::RowBlocks& b = system.row_blocks()[std::size_t(factor.block)];
  const auto row = std::size_t(b.first_row + factor.index * b.rows);
  const auto entry = std::size_t(b.first_entry) +
                     std::size_t(factor.index) * std::size_t(b.rows) * std::size_t(b.columns);
  return {b.rows, b.columns, system.column().data() + entry, system.value().data() + entry,
          system.residual().data() + row};
}

SortedFactors::SortedFactors(const LinearSystem& system, const ColumnLayout& layout,
                             const std::vector<int>& window_of)
    : start_(2 * window_of.size() + 1, 0) {
  const auto columns_of = [&](int block, int i) {
    const FactorRows rows = rows_of(system, {block, i});
    return std::span(rows.column, std::size_t(rows.columns));
  };
  sort(system.row_blocks(), columns_of, layout, window_of);
}

SortedFactors::SortedFactors(const FactorTable& table, const ColumnLayout& layout,
                             const std::vector<int>& window_of)
    : start_(2 * window_of.size() + 1, 0) {
  std::vector<int> columns;
  const auto columns_of = [&](int block, int i) {
    columns.resize(std::size_t(table.row_blocks()[std::size_t(block)].columns));
    table.columns_of(block, i, columns.data());
    return std::span<const int>(columns);
  };
  sort(table.row_blocks(), columns_of, layout, window_of);
}

template <class Columns>
void SortedFactors::sort(std::span<const LinearSystem::RowBlocks> blocks, const Columns& columns_of,
                         const ColumnLayout& layout, const std::vector<int>& window_of) {
  const int windows =
      window_of.empty() ? 0 : *std::max_element(window_of.begin(), window_of.end()) + 1;
  links_.resize(std::size_t(std::max(windows, 0)));
  struct Found {
    FactorAt factor;
    std::size_t list;
  };
  std::vector<Found> found;
  for (int b = 0; b < int(blocks.size()); ++b) {
    for (int i = 0; i < blocks[std::size_t(b)].count; ++i) {
      const Span span = span_of(columns_of(b, i), layout);
      if (span.first < 0) {
        priors_.push_back({b, i});
        continue;
      }
      const int first = window_of[std::size_t(span.first)],
                last = window_of[std::size_t(span.last)];
      if (first < 0 || last < 0) continue;
      if (first != last) {
        links_[std::size_t(last)].push_back({b, i});
        continue;
      }
      found.push_back({{b, i}, std::size_t(2 * span.last + (span.first < span.last ? 1 : 0))});
      ++start_[found.back().list + 1];
    }
  }
  for (std::size_t n = 1; n < start_.size(); ++n) start_[n] += start_[n - 1];
  std::vector<int> next(start_.begin(), start_.end() - 1);
  within_.resize(found.size());
  for (const Found& f : found) within_[std::size_t(next[f.list]++)] = f.factor;
}

}  // namespace magimu
