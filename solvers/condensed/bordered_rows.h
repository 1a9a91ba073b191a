// SPDX-License-Identifier: BSD-3-Clause
// Puts rows of a linearized graph into a chain with a border (kernels/bordered_chain.h): their
// products among the chain's nodes, with the border, and within the border. There are most of the
// last, so factors of one kind are gathered over their own columns, which are fewer than the
// border's.
#pragma once

#include <optional>

#include "solvers/condensed/factors_at_hand.h"
#include "solvers/kernels/bordered_chain.h"

namespace magimu {

class BorderedRows {
 public:
  // The chain's border is [the unknowns of the node `edge` | globals | residual]; edge: -1 for
  // none. globals: their positions in the layout; all others are taken for zero.
  // blocks: number of blocks of factors of one kind (LinearSystem::row_blocks()).
  BorderedRows(std::size_t blocks, const ColumnLayout& layout, BorderedChain& chain, int edge,
               const std::vector<int>& globals);

  // older, newer: which nodes the chain's two are, -1 for none.
  void add(const FactorsAtHand& factors, FactorAt factor, int older, int newer);
  void finish();
  // Of the edge's information, before anything was eliminated.
  const std::vector<double>& edge_diagonal() const { return edge_diagonal_; }

 private:
  // Globals that follow each other in a factor's rows, in a group's, and in the border.
  struct Run {
    int from, at, to, count;
  };
  // Factors of one batch with the same globals. Its rows: these, then the residual.
  struct Group {
    std::vector<int> entries, columns;  // in the factor's rows, of the system
    std::vector<Run> runs;
    std::optional<SquareSum> squares;
  };
  struct Entry {
    int from, to;  // in the factor's rows; in the chain, or in the border
  };

  void sort_entries(const FactorRows& factor, int older, int newer);
  bool has_these(const Group& group, const FactorRows& factor) const;
  void open(Group& group, const FactorRows& factor) const;
  void close(Group& group);
  void add_within_border(Group& group, const FactorRows& factor);
  void add_to_nodes(const Group& group, const FactorRows& factor);

  const ColumnLayout& layout_;
  BorderedChain& chain_;
  int edge_;
  std::vector<double> edge_diagonal_;
  std::vector<int> place_;  // of a global in the border, -1: none
  std::vector<Group> groups_;
  // Of the factor at hand.
  std::vector<Entry> of_nodes_, of_edge_;
  std::vector<int> of_globals_;  // where in its rows
};

}  // namespace magimu
