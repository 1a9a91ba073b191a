// SPDX-License-Identifier: BSD-3-Clause
// The times of a log's sensors. In most logs the times of each sensor increase, and are used as
// they are, without more memory (logs may have gigabytes). For all other logs the rules for the
// rows of a text file apply (row_times.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "recording/data/times/row_times.h"

namespace magimu {

// Times of one sensor.
struct LogTimes {
  std::uint32_t bit = 0;  // RawRows'
  const std::vector<std::int64_t>* t_ns = nullptr;
};

// Rows: samples one after another in the file, of one time and of different sensors.
// order: the number in `sensors` of each sample, in the file's order.
//
// How many rows come later than ones of a later time, if that is all there is to be said of the
// times: each sensor's increase, no clock was set, nothing was stamped on arrival. Else nothing.
std::optional<std::size_t> late_rows_of_orderly(const std::vector<LogTimes>& sensors,
                                                const std::vector<std::uint8_t>& order);

// Input for row_times(): times in s from origin_ns plus shift_s. `row`: the row of each sample, by
// sensor.
RawRows rows_of_log(const std::vector<LogTimes>& sensors, const std::vector<std::uint8_t>& order,
                    std::int64_t origin_ns, double shift_s,
                    std::vector<std::vector<std::uint32_t>>& row);

// Seconds from an origin. Computed in doubles: the difference of far-off times may overflow 64
// bits.
inline double log_seconds(std::int64_t t_ns, std::int64_t origin_ns) {
  const double s = double(t_ns) * 1e-9 - double(origin_ns) * 1e-9;
  return s > -1e9 && s < 1e9 ? double(t_ns - origin_ns) * 1e-9 : s;
}

}  // namespace magimu
