// SPDX-License-Identifier: BSD-3-Clause
#include "recording/phone_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <optional>

#include "recording/csv_columns.h"
#include "recording/csv_parser.h"
#include "recording/error.h"
#include "recording/read_file.h"

namespace magimu {
namespace {

struct SensorFiles {
  const char* sensor;
  std::initializer_list<const char*> names;  // the best first
};
const SensorFiles kSensors[] = {
    {"acc", {"TotalAcceleration.csv", "AccelerometerUncalibrated.csv", "Accelerometer.csv"}},
    {"gyr", {"GyroscopeUncalibrated.csv", "Gyroscope.csv"}},
    {"mag", {"MagnetometerUncalibrated.csv", "Magnetometer.csv"}}};

// The first of these files that is there and has more than a header (apps write empty ones).
std::optional<std::filesystem::path> file_of(const std::string& folder, const SensorFiles& files) {
  constexpr std::uintmax_t kMoreThanAHeader = 200;
  std::error_code error;
  for (const char* name : files.names) {
    const std::filesystem::path path = std::filesystem::path(folder) / name;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (!error && size > kMoreThanAHeader) return path;
  }
  return std::nullopt;
}

// Columns that are called just "x", "y", "z".
void map_bare_axes(std::string_view header, const std::string& sensor, CsvOptions& options) {
  while (true) {
    const std::size_t end = std::min(header.find(','), header.size());
    const std::string_view name = csv_trimmed(header.substr(0, end));
    if (name == "x" || name == "y" || name == "z") {
      options.columns[std::string(name)] = sensor + "_" + std::string(name);
    }
    if (end == header.size()) return;
    header.remove_prefix(end + 1);
  }
}

Recording read_one(const std::filesystem::path& path, const std::string& sensor,
                   CsvOptions options) {
  options.require_mag = options.require_imu = false;
  options.keep_origin = true;
  const std::string content = read_file(path.string());
  const std::string_view header =
      std::string_view(content).substr(0, content.find_first_of("\r\n"));
  map_bare_axes(header, sensor, options);
  return csv_recording(content, path.string(), options);
}

// Seconds since 1970 are so large that a double holds them less exactly than times are told apart.
void count_from_first(Recording& r) {
  constexpr double kTooLarge = 1e6;  // s
  std::vector<std::vector<double>*> all = {&r.acc.t, &r.gyr.t};
  for (VectorSeries& mag : r.mag) all.push_back(&mag.t);
  double first = r.acc.t.front();
  for (const std::vector<double>* t : all) first = std::min(first, t->front());
  if (std::abs(first) < kTooLarge) return;
  for (std::vector<double>* t : all) {
    for (double& time : *t) time -= first;
  }
  r.notes.push_back(fmt::format("the times count from the first sample, at {:.3f} s", first));
}

}  // namespace

bool is_phone_folder(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return false;
  for (const SensorFiles& files : kSensors) {
    if (!file_of(path, files)) return false;
  }
  return true;
}

Recording read_phone_folder(const std::string& path, const CsvOptions& options) {
  if (!options.columns.empty()) {
    throw InputError(path, 0, 0, "a phone's folder has names of its own",
                     "give no mapping of columns (--map) with it");
  }
  if (options.rate_hz) {
    throw InputError(path, 0, 0, "a phone's sensors have times and rates of their own",
                     "give no --rate with it");
  }
  Recording out;
  const std::filesystem::path folder(path);
  out.name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  for (const SensorFiles& files : kSensors) {
    const std::filesystem::path file = file_of(path, files).value();
    const std::string sensor = files.sensor;
    Recording part = read_one(file, sensor, options);
    const bool there = sensor == "mag"   ? !part.mag.empty()
                       : sensor == "acc" ? !part.acc.empty()
                                         : !part.gyr.empty();
    if (!there) {
      throw InputError(file.string(), 0, 0, "there are no columns of " + sensor,
                       "give one CSV file with all sensors instead");
    }
    if (sensor == "acc") out.acc = std::move(part.acc);
    if (sensor == "gyr") out.gyr = std::move(part.gyr);
    if (sensor == "mag") {
      out.mag = std::move(part.mag);
      out.mag_names = std::move(part.mag_names);
    }
    out.notes.push_back(sensor + " is from " + file.filename().string());
    for (const std::string& note : part.notes) {
      out.notes.push_back(file.filename().string() + ": " + note);
    }
    for (const std::string& caution : part.cautions) {
      out.cautions.push_back(file.filename().string() + ": " + caution);
    }
  }
  count_from_first(out);
  return out;
}

}  // namespace magimu
