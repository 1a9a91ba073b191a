// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed/windowed_system.h"

#include <numeric>

namespace magimu {

WindowedSystem::WindowedSystem(const LinearSystem* linearized, const FactorTable* not_linearized,
                               const Values& at, const std::function<int(Key)>& node_of,
                               const std::vector<int>& window_of)
    : system(linearized),
      table(not_linearized),
      values(at),
      blocks(system != nullptr ? system->row_blocks() : table->row_blocks()),
      layout(values, node_of, window_of.size()),
      sorted(system != nullptr ? SortedFactors(*system, layout, window_of)
                               : SortedFactors(*table, layout, window_of)),
      windows(std::size_t(sorted.windows())) {
  for (int node = 0; node < int(window_of.size()); ++node) {
    const int w = window_of[std::size_t(node)];
    if (w < 0) continue;
    Window& own = windows[std::size_t(w)];
    if (own.first < 0) own.first = node;
    own.last = node;
  }
}

int WindowedSystem::count_rows(std::span<const FactorAt> factors) const {
  int rows = 0;
  for (const FactorAt f : factors) rows += blocks[std::size_t(f.block)].rows;
  return rows;
}

std::vector<int> WindowedSystem::touched(const FactorsAtHand& at_hand,
                                         std::span<const FactorAt> factors) const {
  std::vector<int> out;
  std::vector<char> seen(layout.globals.size(), 0);
  for (const FactorAt f : factors) {
    const FactorRows rows = at_hand.rows(f);
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

std::vector<int> WindowedSystem::all_globals() const {
  std::vector<int> all(layout.globals.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

CondensedWindow nothing_about(std::size_t globals) {
  const auto g = Eigen::Index(globals);
  CondensedWindow out;
  out.information.setZero(g, g);
  out.score.setZero(g);
  return out;
}

CondensedWindow condensed(const SquareSum& border, int skip, const std::vector<int>& order,
                          std::size_t globals) {
  CondensedWindow out = nothing_about(globals);
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

void add_to(CondensedWindow& sum, const CondensedWindow& w, double sign) {
  sum.information += sign * w.information;
  sum.score += sign * w.score;
  sum.squares += sign * w.squares;
  sum.log_det += sign * w.log_det;
  sum.rows += w.rows;
}

}  // namespace magimu
