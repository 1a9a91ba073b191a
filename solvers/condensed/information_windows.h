// SPDX-License-Identifier: BSD-3-Clause
// Windows condensed in the information form (condensed_windows.h).
#pragma once

#include "solvers/condensed/windowed_system.h"

namespace magimu {

// Fills in the windows and what links them. Returns the smallest pivot over its diagonal before
// anything was eliminated: about 1e-16 over it is the accuracy of the result. Once that falls below
// `enough`, no more is computed.
double condense_information(const WindowedSystem& s, double enough, CondensedChain& out);

}  // namespace magimu
