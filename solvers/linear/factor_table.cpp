// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/linear/factor_table.h"

#include "graph/slot_finder.h"

namespace magimu {

FactorTable::FactorTable(const FactorGraph& graph, const Values& values) {
  std::vector<char> used(std::size_t(values.dim()), 0);
  int rows = 0, entries = 0;
  for (const auto& batch : graph.batches()) {
    parts_.push_back({batch.get(), resolve(*batch, values, used)});
    row_blocks_.push_back({rows, entries, batch->size(), batch->rows(), batch->columns()});
    rows += batch->size() * batch->rows();
    entries += batch->size() * batch->rows() * batch->columns();
  }
}

void FactorTable::columns_of(int block, int i, int* out) const {
  const Part& part = parts_[std::size_t(block)];
  const auto types = part.batch->types();
  for (std::size_t j = 0; j < types.size(); ++j) {
    const int tangent = part.keys.tangent[std::size_t(i) * types.size() + j];
    for (int c = 0; c < types[j].tangent(); ++c) *out++ = tangent + c;
  }
}

void FactorTable::linearize(const Values& values, int block, int begin, int end, double* residual,
                            double* value) const {
  const Part& part = parts_[std::size_t(block)];
  part.batch->linearize(values.data(), part.keys, begin, end, residual, value);
}

}  // namespace magimu
