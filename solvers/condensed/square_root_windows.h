// SPDX-License-Identifier: BSD-3-Clause
// Windows condensed in the square-root form (condensed_windows.h): reflections of the rows
// themselves, node after node. A direction with a millionth of the norm of others then loses six
// digits of sixteen; in the information form it would lose twelve. Rows that are left on the
// globals alone are added up as squares.
#pragma once

#include "solvers/condensed/windowed_system.h"

namespace magimu {

// Fills in the windows and what links them.
void condense_square_root(const WindowedSystem& s, CondensedChain& out);

}  // namespace magimu
