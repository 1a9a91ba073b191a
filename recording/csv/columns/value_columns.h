// SPDX-License-Identifier: BSD-3-Clause
// Which of the columns of numbers of a table in long format (a row is one sensor's) are x, y and z,
// where the rows hold more: a second clock, a counter, an accuracy, a temperature, the biases that
// a phone subtracted. Internal to long_format_dialect.cpp.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace magimu {

// The numbers of one column, those of each sensor in their order.
struct NumberColumn {
  std::size_t field = 0;
  std::string name;  // in the header; empty: it has none
  std::vector<std::vector<double>> of_sensor;
  // Whether more than half of the rows of every sensor have a number here.
  bool every_sensor_has_it = true;
};

// Whether it may be a clock: its numbers hardly ever fall from one row of a sensor to the next.
bool is_clock_or_counter(const NumberColumn& column);
// Whether it is none beyond doubt.
bool falls_as_readings_do(const NumberColumn& column);

// The fields of the axes: by their names ("x", "value_x", "value0", "v1"), else of `count` columns
// that stand one behind the other, the first that nothing speaks against. Where there are no more
// columns than `count`, these. Nothing where there are fewer.
std::vector<std::size_t> value_fields(const std::vector<NumberColumn>& columns, std::size_t count);

}  // namespace magimu
