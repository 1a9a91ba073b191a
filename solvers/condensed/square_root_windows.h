// SPDX-License-Identifier: BSD-3-Clause
// Windows condensed in the square-root form (condensed_windows.h): reflections of the rows
// themselves, node after node, so that a direction of which the rows say a millionth of what they
// say of others loses no more than six digits of sixteen. What is left on the globals alone adds up
// as squares.
#pragma once

#include "solvers/condensed/windowed_system.h"

namespace magimu {

// Fills in the windows and what links them.
void condense_square_root(const WindowedSystem& s, CondensedChain& out);

}  // namespace magimu
