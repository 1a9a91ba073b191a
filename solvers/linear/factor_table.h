// SPDX-License-Identifier: BSD-3-Clause
// A graph's factors and the columns that they touch, for users that linearize a few factors at a
// time. A LinearSystem keeps the numbers of all factors, which would not fit into memory for a long
// recording with many candidate effects.
#pragma once

#include <span>
#include <vector>

#include "graph/linear_system.h"

namespace magimu {

class FactorTable {
 public:
  // Throws std::invalid_argument where a variable is absent or of another type. The graph must
  // outlive this.
  FactorTable(const FactorGraph& graph, const Values& values);

  std::span<const LinearSystem::RowBlocks> row_blocks() const { return row_blocks_; }
  // Writes the columns of factor i of a block to out, in the order of its rows' entries.
  void columns_of(int block, int i, int* out) const;
  // Linearizes factors begin <= i < end of a block at values. Writes their rows one after another:
  // a number a row to residual, a number a row and column to value.
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
