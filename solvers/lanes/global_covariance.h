// SPDX-License-Identifier: BSD-3-Clause
// Covariance of the variables that all nodes of a chain share, all nodes integrated out: what is
// left of the information when the windows are eliminated (window_engine.h), inverted. One pass
// over the factors, a fifth of what Marginals needs, which in turn knows undetermined directions
// and any variable.
#pragma once

#include <optional>
#include <vector>

#include "graph/factor_graph.h"

namespace magimu {

// The joint covariance in the order of `keys`, in their tangent coordinates. Nothing if the graph
// is no chain with globals, if a key is no global, or if the problem is too close to singular.
std::optional<MatrixXd> global_covariance(const FactorGraph& graph, const Values& values,
                                          const std::vector<Key>& keys);

}  // namespace magimu
