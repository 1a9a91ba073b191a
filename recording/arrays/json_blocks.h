// SPDX-License-Identifier: BSD-3-Clause
// Rows of JSON that hold several samples of a sensor under one time, as radios send them:
// {"Timestamp": 5035, "ArrayAcc": [{"x": 1, "y": 2, "z": 3}, {...}, ...]} (Movesense). They become
// rows of one sample each.
#pragma once

#include <string>
#include <vector>

namespace magimu {

// columns: names of flattened rows ("ArrayAcc[1].x"). Does a row hold several readings of an
// accelerometer or a gyroscope? (An array of magnetometers may be several sensors.)
bool has_blocks(const std::vector<std::string>& columns);

// The table as CSV text, one sample a row; empty where no column is a time. A row's time is that of
// its first sample. Its samples are evenly spaced by the median of the sensor's intervals: from one
// row's time to the next, over the number of samples in the row.
std::string spread_blocks(const std::vector<std::string>& columns,
                          const std::vector<std::vector<std::string>>& rows);

}  // namespace magimu
