// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/missing_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "recording/csv/columns/text_fields.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

std::vector<std::string> missing_sensors(const HeaderColumns& columns, const CsvOptions& options) {
  std::vector<std::string> missing;
  for (const char* sensor : {"acc", "gyr"}) {
    if (options.require_imu && !columns.has(sensor)) missing.emplace_back(sensor);
  }
  const bool mag = std::ranges::any_of(
      columns.where, [](const auto& entry) { return entry.first.starts_with("mag"); });
  if (options.require_mag && !mag) missing.emplace_back("mag");
  return missing;
}

// Columns that mean nothing here, but whose names differ in x, y and z alone.
std::vector<std::array<std::string, 3>> unnamed_sensors(const HeaderColumns& columns) {
  std::vector<std::pair<std::string, std::array<std::string, 3>>> groups;
  for (std::size_t i = 0; i < columns.headers.size(); ++i) {
    const std::string& header = columns.headers[i];
    std::string stem = header.substr(0, header.find_first_of("(["));
    while (!stem.empty() && stem.back() == ' ') stem.pop_back();
    const std::size_t axis =
        stem.empty() ? std::string::npos : std::string_view("xyzXYZ").find(stem.back());
    if (columns.named[i] || axis == std::string::npos) continue;
    stem.pop_back();
    auto group = std::ranges::find(groups, stem, [](const auto& g) { return g.first; });
    if (group == groups.end()) group = groups.insert(groups.end(), {stem, {}});
    group->second[axis % 3] = header;
  }
  std::vector<std::array<std::string, 3>> whole;
  for (const auto& [stem, axes] : groups) {
    if (std::ranges::none_of(axes, &std::string::empty)) whole.push_back(axes);
  }
  return whole;
}

// One line of options for them: with the names that are left, where these are as many sensors, in
// the usual order.
std::string map_line(const HeaderColumns& columns, const std::vector<std::string>& sensors) {
  const std::vector<std::array<std::string, 3>> left = unnamed_sensors(columns);
  std::vector<std::string> maps;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string ours = sensors[i] + '_' + "xyz"[axis];
      maps.push_back("--map " + (left.size() == sensors.size()
                                     ? shell_word(ours + '=' + left[i][axis])
                                     : ours + "=NAME"));
    }
  }
  return fmt::format("{}", fmt::join(maps, " "));
}

// Where no column is left that could be a sensor, it was not recorded, and no option helps.
std::string record_them(const HeaderColumns& columns, const std::vector<std::string>& sensors) {
  if (sensors.empty() || unnamed_sensors(columns).size() >= sensors.size()) return "";
  std::vector<std::string> words;
  for (const std::string& sensor : sensors) {
    words.push_back(sensor == "acc"   ? "an accelerometer"
                    : sensor == "gyr" ? "a gyroscope"
                                      : "a magnetometer");
  }
  return fmt::format("record {}, too; or, if it is in the file, ", fmt::join(words, " and "));
}

}  // namespace

bool HeaderColumns::has(const std::string& sensor) const {
  const auto first = where.lower_bound(sensor + '_');
  return first != where.end() && first->first.starts_with(sensor + '_');
}

std::string HeaderColumns::shown() const {
  std::vector<std::string> texts;
  for (const std::string& header : headers) texts.push_back(quoted_text(header));
  if (texts.size() > 40) texts.resize(40);
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::optional<MissingColumns> missing_columns(const HeaderColumns& columns,
                                              const CsvOptions& options) {
  const bool no_time = !columns.where.contains("t") && !options.rate_hz;
  const std::vector<std::string> sensors = missing_sensors(columns, options);
  if (!no_time && sensors.empty()) return std::nullopt;
  std::vector<std::string> names;
  for (const std::string& sensor : sensors) {
    for (const char axis : {'x', 'y', 'z'}) names.push_back(sensor + '_' + axis);
  }
  const std::string all =
      names.empty() ? ""
                    : fmt::format("the columns {} and {} are missing",
                                  fmt::join(names.begin(), names.end() - 1, ", "), names.back());
  const std::string there = "; the columns there are: " + columns.shown();
  const std::string record = record_them(columns, sensors);
  if (no_time) {
    return MissingColumns{
        true, "there is no column t, the time" + (all.empty() ? "" : ", and " + all) + there,
        "name the time column t (in seconds), or map it to t (--map t=NAME); without times give "
        "the rate, --rate HZ" +
            (sensors.empty()
                 ? ""
                 : "; " + record + "map the others, too (" + map_line(columns, sensors) + ")")};
  }
  return MissingColumns{false, all + there,
                        (record.empty() ? "add them, or " : record) +
                            "map the file's own names to these (" + map_line(columns, sensors) +
                            "); of an app that writes one file a sensor (phyphox, Sensor Logger) "
                            "give the folder"};
}

}  // namespace magimu
