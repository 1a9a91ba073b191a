// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/ardupilot_columns.h"

#include <algorithm>

namespace magimu {
namespace {

std::optional<std::size_t> axis_behind(std::string_view header, std::string_view front) {
  if (header.size() != front.size() + 1 || !header.starts_with(front)) return std::nullopt;
  const std::size_t axis = std::string_view("XYZ").find(header.back());
  return axis == std::string_view::npos ? std::nullopt : std::optional(axis);
}

}  // namespace

bool are_ardupilot_columns(const std::vector<CsvColumns::Field>& fields) {
  const auto has = [&](std::string_view header) {
    return std::ranges::find(fields, header, &CsvColumns::Field::header) != fields.end();
  };
  return (has("TimeUS") || has("TimeMS")) && (has("MagX") || has("GyrX"));
}

bool is_ardupilot_compass(const std::string& header) {
  return axis_behind(header, "Mag").has_value();
}

std::optional<std::size_t> ardupilot_offset_axis(const std::string& header) {
  const auto offset = axis_behind(header, "Ofs");
  return offset ? offset : axis_behind(header, "MO");
}

}  // namespace magimu
