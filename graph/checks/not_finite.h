// SPDX-License-Identifier: BSD-3-Clause
// Which variable or factor holds a number that is not finite: looked for when a sum of all has
// shown that there is one, so that nobody else pays for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graph/factor_graph.h"

namespace magimu {

struct NotFinite {
  std::vector<Key> keys;  // of the factor; the variable alone where that is at fault
  // "variable x3", "the residual of the factor on (x3, x4)", "a Jacobian of the factor on ...",
  // "the square of the residual of the factor on ..."
  std::string what;
};

// The first in the order of the values and then of the graph; nothing where all are finite.
// Variables of factors must be in values.
std::optional<NotFinite> find_not_finite(const FactorGraph& graph, const Values& values);

// "the factor on (x3, x4)"
std::string name_of_factor(std::span<const Key> keys);

}  // namespace magimu
