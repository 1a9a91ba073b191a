// SPDX-License-Identifier: BSD-3-Clause
// Parameters that stay where they are while something else is fitted.
#pragma once

#include "graph/factor_graph.h"
#include "graph/values.h"

namespace magimu {

inline constexpr double kHeldShare =
    1e-3;  // of a standard deviation: a millionth of the information

// A prior on each variable of `globals` (double, Vector3, Matrix3 or GyroMatrix) that lets it
// move by kHeldShare of its standard deviation. sigma: one entry a degree of freedom.
void hold_globals(const Values& globals, const VectorXd& sigma, FactorGraph& graph);

}  // namespace magimu
