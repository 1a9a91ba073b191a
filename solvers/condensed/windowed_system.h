// SPDX-License-Identifier: BSD-3-Clause
// A linearized chain cut into windows, and what both forms of condensing these (information_windows
// and square_root_windows.h) have in common.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solvers/condensed/condensed_windows.h"
#include "solvers/condensed/factors_at_hand.h"
#include "solvers/kernels/square_sum.h"

namespace magimu {

struct WindowedSystem {
  // The first node and the last, the same where there is but one; -1: none.
  struct Window {
    int first = -1, last = -1;
  };

  // As condense() (condensed_windows.h). One of linearized and table is null.
  WindowedSystem(const LinearSystem* linearized, const FactorTable* table, const Values& values,
                 const std::function<int(Key)>& node_of, const std::vector<int>& window_of);

  int dim(int node) const { return node < 0 ? 0 : layout.dim[std::size_t(node)]; }
  std::span<const FactorAt> factors(const Window& w) const { return sorted.of(w.first, w.last); }
  int count_rows(std::span<const FactorAt> factors) const;
  FactorsAtHand at_hand(std::span<const FactorAt> factors) const {
    return system != nullptr ? FactorsAtHand(*system) : FactorsAtHand(*table, values, factors);
  }
  // The globals that factors touch, in the order in which they appear: those of one kind of factor
  // lie side by side.
  std::vector<int> touched(const FactorsAtHand& rows, std::span<const FactorAt> factors) const;
  std::vector<int> all_globals() const;

  const LinearSystem* system;
  const FactorTable* table;
  const Values& values;
  std::span<const LinearSystem::RowBlocks> blocks;
  ColumnLayout layout;
  SortedFactors sorted;
  std::vector<Window> windows;
};

// Number of windows that are condensed in parallel before they are linked one after another. It
// limits memory: until it is linked a window keeps a few times as much as it says of the globals.
inline constexpr std::size_t kWindowsAtOnce = 64;

// An empty condensed window over n globals.
CondensedWindow nothing_about(std::size_t globals);
// From a finished border: columns `skip` and on, order are their globals, a residual comes last.
CondensedWindow condensed(const SquareSum& border, int skip, const std::vector<int>& order,
                          std::size_t globals);
void add_to(CondensedWindow& sum, const CondensedWindow& w, double sign = 1.0);

}  // namespace magimu
