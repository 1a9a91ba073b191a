// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed/factors_at_hand.h"

#include <algorithm>

namespace magimu {

FactorsAtHand::FactorsAtHand(const FactorTable& table, const Values& values,
                             std::span<const FactorAt> factors)
    : table_(&table) {
  const auto blocks = table.row_blocks();
  ranges_.resize(blocks.size());
  for (const FactorAt f : factors) {
    Range& r = ranges_[std::size_t(f.block)];
    const bool first = r.begin == r.end;
    r.begin = first ? f.index : std::min(r.begin, f.index);
    r.end = first ? f.index + 1 : std::max(r.end, f.index + 1);
  }
  std::size_t columns = 0, entries = 0, rows = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    Range& r = ranges_[b];
    r.column = columns;
    r.value = entries;
    r.residual = rows;
    const auto own = std::size_t(r.end - r.begin);
    columns += own * std::size_t(blocks[b].columns);
    rows += own * std::size_t(blocks[b].rows);
    entries += own * std::size_t(blocks[b].rows) * std::size_t(blocks[b].columns);
  }
  columns_.resize(columns);
  values_.resize(entries);
  residuals_.resize(rows);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Range& r = ranges_[b];
    for (int i = r.begin; i < r.end; ++i) {
      const auto before = std::size_t(i - r.begin) * std::size_t(blocks[b].columns);
      table.columns_of(int(b), i, columns_.data() + r.column + before);
    }
    if (r.begin == r.end) continue;
    table.linearize(values, int(b), r.begin, r.end, residuals_.data() + r.residual,
                    values_.data() + r.value);
  }
}

FactorRows FactorsAtHand::rows(FactorAt factor) const {
  if (system_ != nullptr) return rows_of(*system_, factor);
  const LinearSystem::RowBlocks& b = table_->row_blocks()[std::size_t(factor.block)];
  const Range& r = ranges_[std::size_t(factor.block)];
  const auto i = std::size_t(factor.index - r.begin), rows = std::size_t(b.rows),
             columns = std::size_t(b.columns);
  return {b.rows, b.columns, columns_.data() + r.column + i * columns,
          values_.data() + r.value + i * rows * columns, residuals_.data() + r.residual + i * rows};
}

}  // namespace magimu
