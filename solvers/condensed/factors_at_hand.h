// SPDX-License-Identifier: BSD-3-Clause
// The rows of some factors. A linear system keeps the rows of all factors. The factors of a table
// are linearized here, and their rows live as long as this.
#pragma once

#include "solvers/linear/node_factors.h"

namespace magimu {

class FactorsAtHand {
 public:
  explicit FactorsAtHand(const LinearSystem& system) : system_(&system) {}
  // Of each batch all factors from the first to the last of these are linearized.
  FactorsAtHand(const FactorTable& table, const Values& values, std::span<const FactorAt> factors);
  FactorRows rows(FactorAt factor) const;

 private:
  struct Range {
    int begin = 0, end = 0;  // factors of a block
    std::size_t column = 0, value = 0, residual = 0;
  };
  const LinearSystem* system_ = nullptr;
  const FactorTable* table_ = nullptr;
  std::vector<Range> ranges_;  // one a block
  std::vector<int> columns_;
  std::vector<double> values_, residuals_;
};

}  // namespace magimu
