// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/axis_gatherer.h"

#include <algorithm>

namespace magimu {

AxisGatherer::AxisGatherer(const std::vector<std::string>& names, bool with_time)
    : with_time_(with_time), values_(names.size()) {
  std::map<std::string, std::size_t> sensors;
  for (std::size_t c = 0; c < names.size(); ++c) {
    // "acc_x" is an axis of "acc", "temp" is a number by itself.
    const std::string& name = names[c];
    const bool axis = name.size() > 2 && name[name.size() - 2] == '_';
    const auto [sensor, is_new] =
        sensors.try_emplace(axis ? name.substr(0, name.size() - 2) : name, sensors.size());
    if (is_new) columns_.emplace_back();
    columns_[sensor->second].push_back(c);
    sensor_of_.push_back(sensor->second);
  }
  times_.resize(columns_.size());
}

std::optional<std::string_view> AxisGatherer::add(std::size_t column, std::string_view time,
                                                  std::string_view value) {
  const std::size_t sensor = sensor_of_[column];
  const std::vector<std::size_t>& axes = columns_[sensor];
  const auto clear = [&] {
    for (const std::size_t c : axes) values_[c].clear();
  };
  const auto is_empty = [this](std::size_t c) { return values_[c].empty(); };
  // An axis that comes again before the others have come: they are lost.
  if (!values_[column].empty()) clear();
  if (std::ranges::all_of(axes, is_empty)) times_[sensor] = time;
  values_[column] = value;
  if (std::ranges::any_of(axes, is_empty)) return std::nullopt;
  out_ = with_time_ ? times_[sensor] : "";
  for (std::size_t c = 0; c < values_.size(); ++c) {
    if (with_time_ || c > 0) out_ += ',';
    if (sensor_of_[c] == sensor) out_ += values_[c];
  }
  clear();
  return out_;
}

}  // namespace magimu
