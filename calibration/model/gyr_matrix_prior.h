// SPDX-License-Identifier: BSD-3-Clause
// What is known beforehand of a gyroscope's scale errors and misalignment S (model.h).
#pragma once

#include "graph/noise.h"

namespace magimu {

// Of the nine entries of S about zero, column by column: data sheets.
Noise<9> gyr_matrix_noise();

}  // namespace magimu
