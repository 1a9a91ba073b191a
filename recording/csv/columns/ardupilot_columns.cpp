// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/ardupilot_columns.h"

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

void take_off_ardupilot_offsets(CsvColumns& columns, std::optional<std::size_t> mag_x) {
  const bool compass = mag_x && is_ardupilot_compass(columns.fields[*mag_x].header);
  for (std::size_t i = 0; i < columns.fields.size(); ++i) {
    CsvColumns::Field& field = columns.fields[i];
    if (field.header == "I" && field.slot == CsvColumns::kIgnored) columns.device = i;
    const std::optional<std::size_t> axis = ardupilot_offset_axis(field.header);
    if (!compass || !axis || field.slot != CsvColumns::kIgnored) continue;
    field.slot = static_cast<int>(columns.vector_slot(2) + *axis);
    field.unit = columns.fields[*mag_x].unit;
    field.taken_off = columns.takes_off = true;
  }
  if (!compass) return;
  columns.notes.emplace_back(
      columns.takes_off
          ? "ArduPilot had added its offsets (OfsX, MOX and the like); they are taken off, so "
            "that the bias found is the whole one: the new COMPASS_OFS is minus the bias. A "
            "matrix (COMPASS_DIA, COMPASS_ODI), if it had one, is not taken off: the "
            "parameters are not in this file, but in the .bin"
          : "ArduPilot adds its offsets (COMPASS_OFS) to what it logs, and this file lacks them "
            "(OfsX, OfsY, OfsZ): the bias found is what they leave");
}

}  // namespace magimu
