// SPDX-License-Identifier: BSD-3-Clause
// A linearized graph seen along its chains of nodes: which columns are a node's and which are
// globals, and the factors in the order of the nodes that they touch.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "graph/values.h"
#include "solvers/linear/factor_table.h"

namespace magimu {

// Where each column of the system belongs.
struct ColumnLayout {
  ColumnLayout(const Values& values, const std::function<int(Key)>& node_of, std::size_t nodes);
  int max_dim() const;

  std::vector<int> node;      // of a column; -1: a global
  std::vector<int> position;  // within the node, or among the globals
  std::vector<int> dim;       // of a node
  std::vector<int> globals;   // their columns
};

// A factor: its number within one of the system's row_blocks().
struct FactorAt {
  int block, index;
};

// Its rows, which share one list of columns.
struct FactorRows {
  int rows, columns;
  const int* column;
  const double* value;  // row by row
  const double* residual;
};
FactorRows rows_of(const LinearSystem& system, FactorAt factor);

// Factors by what they touch.
class SortedFactors {
 public:
  SortedFactors(const LinearSystem& system, const ColumnLayout& layout,
                const std::vector<int>& window_of);
  SortedFactors(const FactorTable& table, const ColumnLayout& layout,
                const std::vector<int>& window_of);

  // Those within a window whose last node is first <= node <= last.
  std::span<const FactorAt> of(int first, int last) const {
    return between(2 * first, 2 * last + 2);
  }
  // Of these, factors that touch this node alone, and those that touch the node before it, too.
  std::span<const FactorAt> own(int node) const { return between(2 * node, 2 * node + 1); }
  std::span<const FactorAt> across(int node) const { return between(2 * node + 1, 2 * node + 2); }
  const std::vector<FactorAt>& priors() const { return priors_; }  // those that touch no node
  // Those between this window and an earlier one.
  const std::vector<FactorAt>& links(int window) const { return links_[std::size_t(window)]; }
  int windows() const { return int(links_.size()); }

 private:
  // columns_of(block, i): the columns of factor i of a block.
  template <class Columns>
  void sort(std::span<const LinearSystem::RowBlocks> blocks, const Columns& columns_of,
            const ColumnLayout& layout, const std::vector<int>& window_of);
  std::span<const FactorAt> between(int begin, int end) const {
    const auto first = std::size_t(start_[std::size_t(begin)]);
    return std::span(within_).subspan(first, std::size_t(start_[std::size_t(end)]) - first);
  }

  std::vector<FactorAt> within_, priors_;
  std::vector<int> start_;  // of each node's own factors, and of those across
  std::vector<std::vector<FactorAt>> links_;
};

}  // namespace magimu
