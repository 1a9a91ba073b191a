// SPDX-License-Identifier: BSD-3-Clause
// In which order to eliminate the columns of a linear system: fill-reducing, with the globals (the
// columns that a large part of all rows share: calibration parameters) last, so that they stay
// a small dense triangle at the end.
#pragma once

#include <vector>

#include "graph/linear_system.h"

namespace magimu {

// 1 for the columns that very many rows share, 0 for the others.
std::vector<int> global_columns(const LinearSystem& system);

}  // namespace magimu
