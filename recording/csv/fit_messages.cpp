// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/fit_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <vector>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/plain_number.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

struct SensorMessage {
  std::string_view message, field;  // field: the name before its axis
  const char* column;
};
// Readings that the device has calibrated come first; counts need another message to have a unit.
constexpr std::array kSensorMessages = {
    SensorMessage{"accelerometer_data", "calibrated_accel_", "acc_"},
    SensorMessage{"accelerometer_data", "accel_", "acc_"},
    SensorMessage{"gyroscope_data", "calibrated_gyro_", "gyr_"},
    SensorMessage{"gyroscope_data", "gyro_", "gyr_"},
    SensorMessage{"magnetometer_data", "calibrated_mag_", "mag_"},
    SensorMessage{"magnetometer_data", "mag_", "mag_"}};

constexpr std::size_t kQuantities = 9, kCellsOfField = 3, kFirstField = 3;

struct Sample {
  double t;  // s
  std::array<std::string, kQuantities> values;
};

struct Field {
  std::string value, unit;
};
using Fields = std::map<std::string, Field>;

double number(std::string_view text) {
  double value = 0.0;
  if (!text.empty()) plain_number(text.data(), text.data() + text.size(), value);
  return value;
}

// Adds the samples of one message; none where it is not one of kSensorMessages.
void add_samples(const std::string& message, const Fields& fields, std::vector<Sample>& samples,
                 std::array<std::string, kQuantities>& units) {
  const auto value = [&](const std::string& name) {
    const auto at = fields.find(name);
    return at == fields.end() ? std::string() : at->second.value;
  };
  for (const SensorMessage& sensor : kSensorMessages) {
    const std::string x = std::string(sensor.field) + 'x';
    if (message != sensor.message || value(x).empty()) continue;
    const double begin = number(value("timestamp")) + 1e-3 * number(value("timestamp_ms"));
    const std::vector<std::string> offsets = text_fields(value("sample_time_offset"), '|');
    const std::size_t first = std::string_view(sensor.column) == "acc_"   ? 0
                              : std::string_view(sensor.column) == "gyr_" ? 3
                                                                          : 6;
    const std::size_t begun = samples.size();
    for (const std::string& offset : offsets)
      samples.push_back({begin + 1e-3 * number(offset), {}});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = std::string(sensor.field) + "xyz"[axis];
      const std::vector<std::string> readings = text_fields(value(name), '|');
      for (std::size_t i = 0; i < std::min(readings.size(), offsets.size()); ++i) {
        samples[begun + i].values[first + axis] = readings[i];
      }
      const auto field = fields.find(name);
      if (field != fields.end()) units[first + axis] = field->second.unit;
    }
    return;
  }
}

}  // namespace

bool is_fit_messages(std::string_view head) {
  constexpr std::string_view kBom = "\xEF\xBB\xBF", kHeader = "Type,Local Number,Message,Field 1";
  if (head.starts_with(kBom)) head.remove_prefix(kBom.size());
  return head.starts_with(kHeader);
}

Recording read_fit_messages(const std::string& path, const CsvOptions& options) {
  std::ifstream file(path, std::ios::binary);
  std::vector<Sample> samples;
  std::array<std::string, kQuantities> units;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("Data,") && !line.starts_with("\"Data\",")) continue;
    const std::vector<std::string> cells = text_fields(line, ',');
    Fields fields;
    for (std::size_t i = kFirstField; i + 1 < cells.size(); i += kCellsOfField) {
      const bool has_unit = i + 2 < cells.size();
      fields[cells[i]] = {cells[i + 1], has_unit ? cells[i + 2] : std::string()};
    }
    if (cells.size() > 2) add_samples(cells[2], fields, samples, units);
  }
  if (samples.empty()) {
    throw InputError(path, 0, 0,
                     "these are messages of a FIT file without accelerometer_data, gyroscope_data "
                     "and magnetometer_data",
                     "record with an app of the watch that logs its sensors' raw data; a usual "
                     "activity has none");
  }
  std::ranges::stable_sort(samples, {}, &Sample::t);
  std::string text = "t (s)";
  for (std::size_t i = 0; i < kQuantities; ++i) {
    text += fmt::format(",{}_{}", std::array{"acc", "gyr", "mag"}[i / 3], "xyz"[i % 3]);
    if (!units[i].empty()) text += " (" + units[i] + ")";
  }
  text += '\n';
  for (const Sample& sample : samples) {
    text += fmt::format("{}", sample.t);
    for (const std::string& value : sample.values) text += "," + value;
    text += '\n';
  }
  Recording out = csv_recording(text, path, options);
  out.notes.insert(out.notes.begin(), "these are messages of a FIT file");
  return out;
}

}  // namespace magimu
