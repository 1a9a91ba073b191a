// SPDX-License-Identifier: BSD-3-Clause
// Where the magnetometers of an array sit, from a file: a header line `x,y,z`, then one line a
// magnetometer, in m, in the axes of the IMU. Lines that begin with # are skipped.
#pragma once

#include <string>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

// Throws InputError, with the line, for any other text.
std::vector<Vector3> read_array_layout(const std::string& path);

}  // namespace magimu
