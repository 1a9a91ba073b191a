// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/struct_number.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "recording/files/log_file.h"

namespace magimu {

std::size_t struct_size(char letter) {
  switch (letter) {
    case 'b':
    case 'B':
      return 1;
    case 'h':
    case 'H':
      return 2;
    case 'i':
    case 'I':
    case 'f':
      return 4;
    case 'q':
    case 'Q':
    case 'd':
      return 8;
    default:
      return 0;
  }
}

double struct_number(std::string_view data, char letter, std::size_t at) {
  switch (letter) {
    case 'b':
      return bytes_as<std::int8_t>(data, at);
    case 'B':
      return bytes_as<std::uint8_t>(data, at);
    case 'h':
      return bytes_as<std::int16_t>(data, at);
    case 'H':
      return bytes_as<std::uint16_t>(data, at);
    case 'i':
      return bytes_as<std::int32_t>(data, at);
    case 'I':
      return bytes_as<std::uint32_t>(data, at);
    case 'q':
      return double(bytes_as<std::int64_t>(data, at));
    case 'Q':
      return double(bytes_as<std::uint64_t>(data, at));
    case 'f':
      return double(bytes_as<float>(data, at));
    case 'd':
      return bytes_as<double>(data, at);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

std::int64_t whole_number(double number, double most) {
  return std::isnan(number) ? 0 : static_cast<std::int64_t>(std::clamp(number, -most, most));
}

}  // namespace magimu
