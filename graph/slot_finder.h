// SPDX-License-Identifier: BSD-3-Clause
// Which slots of the values the keys of a batch's factors name, one factor after another: mostly
// the same parameters again, and nodes one further on than those of the factor before, which one
// look confirms.
#pragma once

#include <vector>

#include "graph/factor_graph.h"
#include "graph/values.h"

namespace magimu {

class SlotFinder {
 public:
  SlotFinder(const Values& values, std::size_t keys) : values_(values), last_(keys, {-1, 0}) {}

  // Of the next factor's key j; -1 where the values have no such key.
  int find(std::size_t j, Key key) {
    const auto slots = values_.slots();
    Last& last = last_[j];
    int s = last.slot + last.stride;
    if (last.slot < 0 || s < 0 || s >= int(slots.size()) || slots[std::size_t(s)].key != key) {
      if (!values_.contains(key)) return -1;
      s = int(&values_.slot(key) - slots.data());
      last.stride = last.slot < 0 ? 0 : s - last.slot;
    }
    last.slot = s;
    return s;
  }

 private:
  struct Last {
    int slot, stride;
  };
  const Values& values_;
  std::vector<Last> last_;
};

// Where the variables of a batch's factors lie in the values. used: one entry a column; set to 1 at
// the first column of each of these variables. Throws std::invalid_argument where a variable is
// absent or of another type.
ResolvedKeys resolve(const FactorBatch& batch, const Values& values, std::vector<char>& used);

}  // namespace magimu
