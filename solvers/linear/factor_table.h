// SPDX-License-Identifier: BSD-3-Clause
// A graph's factors and the columns that they touch, not linearized: for those who look at a few of
// them at a time. A LinearSystem keeps the numbers of all, which of a long recording with many
// candidate effects would not fit into memory.
#pragma once

#include <span>
#include <vector>

#include "graph/linear_system.h"

namespace magimu {

class FactorTable {
 public:
  // Throws std::invalid_argument where a variable is absent or of
  // another type. The graph must outlive this.
  FactorTable(const FactorGraph& graph, const Values& values);

  std::span<const LinearSystem::RowBlocks> row_blocks() const { return row_blocks_; }
  // The columns of factor i of a block, in the order of its rows' entries.
  void columns_of(int block, int i, int* out) const;
  // Factors begin <= i < end of a block at values: their rows one after another.
  void linearize(const Values& values, int block, int begin, int end, double* residual,
                 double* value) const;

 private:
  struct Part {
    const FactorBatch* batch;
    ResolvedKeys keys;
  };
  std::vector<Part> parts_;
  std::vector<LinearSystem::RowBlocks> row_blocks_;
};

}  // namespace magimu
