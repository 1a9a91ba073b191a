// SPDX-License-Identifier: BSD-3-Clause
// Rows of JSON that hold several samples of a sensor under one time, as radios send them:
// {"Timestamp": 5035, "ArrayAcc": [{"x": 1, "y": 2, "z": 3}, {...}, ...]} (Movesense). They become
// rows of one sample each.
#pragma once

#include <string>
#include <vector>

namespace magimu {

// Columns of flattened rows ("ArrayAcc[1].x"): whether an accelerometer or a gyroscope has several
// readings a row. (Several magnetometers may be an array of them.)
bool has_blocks(const std::vector<std::string>& columns);

// The table as text. A row's time is that of its first sample; its samples are evenly spaced, at
// the usual interval between that sensor's rows.
std::string spread_blocks(const std::vector<std::string>& columns,
                          const std::vector<std::vector<std::string>>& rows);

}  // namespace magimu
