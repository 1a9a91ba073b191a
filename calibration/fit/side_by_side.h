// SPDX-License-Identifier: BSD-3-Clause
// Fits of one recording that do not depend on each other. Each holds a graph, its linear system and
// a copy of that in the order of SIMD lanes: of a long recording several at once would not fit into
// memory, and the loops within one keep all threads busy anyway. The results are the same.
#pragma once

#include <vector>

#include "calibration/motion/nodes.h"
#include "graph/parallel.h"

namespace magimu {

// So many nodes that fits of them should not be in memory several at once.
inline bool are_many(const std::vector<NodePlan>& plans) {
  constexpr std::size_t kManyNodes = 12000;  // a quarter of an hour of the fits before the last
  std::size_t nodes = 0;
  for (const NodePlan& plan : plans) nodes += plan.t.size();
  return nodes > kManyNodes;
}

// bodies: fits with these nodes. In parallel, or one after another where there are many nodes.
template <class... Bodies>
void side_by_side(const std::vector<NodePlan>& plans, const Bodies&... bodies) {
  if (are_many(plans)) {
    (bodies(), ...);
  } else {
    parallel::invoke(bodies...);
  }
}

}  // namespace magimu
