// SPDX-License-Identifier: BSD-3-Clause
// condense() (condensed_windows.h) of a graph that was not linearized before: only the rows of a
// few windows are in memory at a time. The results have the same bits.
#pragma once

#include "solvers/condensed/condensed_windows.h"
#include "solvers/linear/factor_table.h"

namespace magimu {

// Linearized at values.
CondensedChain condense(const FactorTable& table, const Values& values,
                        const std::function<int(Key)>& node_of, const std::vector<int>& window_of,
                        std::optional<EliminationForm> form = {});

}  // namespace magimu
