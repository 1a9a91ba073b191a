// SPDX-License-Identifier: BSD-3-Clause
// Rows of lines that hold one number each: the axes of a sensor are gathered until all are there.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

class AxisGatherer {
 public:
  // names: of the columns, "acc_x" or what means it; of one sensor's axes as ours say.
  AxisGatherer(const std::vector<std::string>& names, bool with_time);

  // The row, once the sensor is whole: its time (that of its first axis) in front, the other
  // sensors' fields empty. Valid until the next call.
  std::optional<std::string_view> add(std::size_t column, std::string_view time,
                                      std::string_view value);

 private:
  std::vector<std::size_t> sensor_of_;             // by column
  std::vector<std::vector<std::size_t>> columns_;  // by sensor
  bool with_time_;
  std::vector<std::string> values_;  // by column, of the rows that are not whole yet
  std::vector<std::string> times_;   // by sensor
  std::string out_;
};

}  // namespace magimu
