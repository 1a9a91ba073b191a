// SPDX-License-Identifier: BSD-3-Clause
#include "recording/arrays/json_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "recording/csv/columns/csv_columns.h"

namespace magimu {
namespace {

constexpr std::array<std::string_view, 9> kQuantities = {
    "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z", "mag_x", "mag_y", "mag_z"};
constexpr std::size_t kAxes = 3, kHowManySensors = kQuantities.size() / kAxes;

struct BlockColumn {
  std::size_t sample, quantity;  // which sample of the block; which of kQuantities
};

std::optional<std::size_t> whole_number(std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string_view last_part(std::string_view name) { return name.substr(name.rfind('.') + 1); }

// "imu9.ArrayAcc[1].x" or "acc[1][0]".
std::optional<BlockColumn> block_column(std::string_view name) {
  const std::size_t open = name.find('['), close = name.find(']');
  if (open == name.npos || close == name.npos || close < open) return std::nullopt;
  const auto sample = whole_number(name.substr(open + 1, close - open - 1));
  std::string_view sensor = last_part(name.substr(0, open)), axis = name.substr(close + 1);
  constexpr std::string_view kArray = "Array";
  if (sensor.starts_with(kArray)) sensor.remove_prefix(kArray.size());
  std::string dotted(axis);
  if (axis == "[0]" || axis == "[1]" || axis == "[2]") {
    dotted = std::string(".") + "xyz"[axis[1] - '0'];
  }
  const std::string ours = csv_column_name(std::string(sensor) + dotted);
  const auto* const quantity = std::ranges::find(kQuantities, ours);
  if (!sample || quantity == kQuantities.end()) return std::nullopt;
  return BlockColumn{*sample, std::size_t(quantity - kQuantities.begin())};
}

struct Sample {
  double t;
  std::array<std::string, kQuantities.size()> values;
};

double number_or_nan(const std::string& text) {
  double value = NAN;
  const char* const end = text.data() + text.size();
  return std::from_chars(text.data(), end, value).ptr == end && !text.empty() ? value : NAN;
}

// Median interval between samples of one sensor, in the unit of its times. blocks: time and number
// of samples of each.
double usual_interval(const std::vector<std::pair<double, std::size_t>>& blocks) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    const double dt = (blocks[i].first - blocks[i - 1].first) / double(blocks[i - 1].second);
    if (dt > 0.0) intervals.push_back(dt);
  }
  if (intervals.empty()) return 0.0;
  const auto middle = intervals.begin() + std::ptrdiff_t(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  return *middle;
}

}  // namespace

bool has_blocks(const std::vector<std::string>& columns) {
  constexpr std::size_t kMag = 6;
  return std::ranges::any_of(columns, [](const std::string& name) {
    const auto column = block_column(name);
    return column && column->sample > 0 && column->quantity < kMag;
  });
}

std::string spread_blocks(const std::vector<std::string>& columns,
                          const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::optional<BlockColumn>> blocks;
  std::vector<std::size_t> times;
  for (const std::string& name : columns) {
    if (csv_column_name(last_part(name)) == "t") times.push_back(blocks.size());
    blocks.push_back(block_column(name));
  }
  if (times.empty()) return "";
  const auto time = [&](const std::vector<std::string>& row) {
    for (const std::size_t i : times) {
      if (i < row.size() && !row[i].empty()) return number_or_nan(row[i]);
    }
    return double(NAN);
  };
  // How many samples of a sensor a row holds.
  const auto samples = [&](const std::vector<std::string>& row, std::size_t sensor) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (row[i].empty() || !blocks[i] || blocks[i]->quantity / kAxes != sensor) continue;
      count = std::max(count, blocks[i]->sample + 1);
    }
    return count;
  };
  std::array<std::vector<std::pair<double, std::size_t>>, kHowManySensors> of_sensor;
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t s = 0; s < kHowManySensors; ++s) {
      if (const std::size_t count = samples(row, s)) of_sensor[s].emplace_back(time(row), count);
    }
  }
  std::array<double, kHowManySensors> interval{};
  for (std::size_t s = 0; s < kHowManySensors; ++s) interval[s] = usual_interval(of_sensor[s]);
  std::vector<Sample> out;
  for (const std::vector<std::string>& row : rows) {
    std::map<double, Sample> at;  // sensors of one rate share rows
    const double begin = time(row);
    for (std::size_t i = 0; i < row.size() && std::isfinite(begin); ++i) {
      if (row[i].empty() || !blocks[i]) continue;
      const auto [sample, quantity] = *blocks[i];
      const double t = begin + double(sample) * interval[quantity / kAxes];
      Sample& one = at.try_emplace(t, Sample{t, {}}).first->second;
      one.values[quantity] = row[i];
    }
    for (auto& [t, sample] : at) out.push_back(std::move(sample));
  }
  std::ranges::stable_sort(out, {}, &Sample::t);
  std::string text(
      columns[times.front()].begin() + std::ptrdiff_t(columns[times.front()].rfind('.') + 1),
      columns[times.front()].end());
  for (const std::string_view quantity : kQuantities) text += fmt::format(",{}", quantity);
  text += '\n';
  for (const Sample& sample : out) {
    text += fmt::format("{}", sample.t);
    for (const std::string& value : sample.values) text += "," + value;
    text += '\n';
  }
  return text;
}

}  // namespace magimu
