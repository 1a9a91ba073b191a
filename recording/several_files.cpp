// SPDX-License-Identifier: BSD-3-Clause
#include "recording/several_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <set>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/words.h"
#include "recording/csv/one_clock.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/devices_of_files.h"
#include "recording/read.h"

namespace magimu {
namespace {

constexpr std::size_t kMostFiles = 4096;

std::string stem_of(const std::string& name) {
  std::string stem = std::filesystem::path(name).stem().string();
  if (stem.ends_with(".csv") || stem.ends_with(".txt")) stem.resize(stem.size() - 4);
  while (!stem.empty() && std::isdigit(static_cast<unsigned char>(stem.back())) != 0) {
    stem.pop_back();
  }
  while (!stem.empty() && (stem.back() == '_' || stem.back() == '-')) stem.pop_back();
  return stem;
}

// Which of PX4's topics is nearest to the sensor.
struct TopicRank {
  const char* ending;
  int rank;
};
constexpr TopicRank kTopicRanks[] = {{"sensor_combined", 30},
                                     {"sensor_mag", 25},
                                     {"vehicle_magnetometer", 24},
                                     {"sensor_accel", 20},
                                     {"sensor_gyro", 20},
                                     {"vehicle_acceleration", 10},
                                     {"vehicle_angular_velocity", 10}};

// What a file's columns would mean that are called just x, y, z. Behind the sensor's word there may
// be a rate, a version, a date ("..._Accelerometer_50.000Hz_1.5.0", MetaWear), "data", " (1)"
// (browsers).
CsvName meaning_of(std::string stem) {
  constexpr std::string_view kOfNoMeaning[] = {"", "data", "raw", "log", "sensor", "samples"};
  while (true) {
    const std::size_t last = stem.find_last_of("_- .");
    const std::string word = plain_words(std::string_view(stem).substr(last + 1));
    const bool number = word.find_first_of("(0123456789") == 0;
    if (!number || last == std::string::npos) {
      CsvName meaning = csv_name(stem + "_x");
      const bool more = word.find_first_of("0123456789") != std::string::npos ||
                        std::ranges::find(kOfNoMeaning, word) != std::end(kOfNoMeaning);
      if (!meaning.name.empty() || !more || last == std::string::npos) return meaning;
    }
    stem.resize(last);
  }
}

// "HighGAccelerometer" (x-IMU3), "acc_high_g", "H3LIS331": for shocks of hundreds of g, and noisy.
bool has_high_range(const std::string& stem) {
  std::string words = plain_words(stem);
  std::erase_if(words, [](char c) { return c == '_' || c == '-' || c == ' '; });
  return std::ranges::any_of(std::initializer_list<const char*>{"highg", "h3lis", "adxl37"},
                             [&](const char* word) { return words.find(word) != words.npos; });
}

int rank_of(const std::string& name) {
  const std::string stem = stem_of(name);
  for (const TopicRank& topic : kTopicRanks) {
    if (stem.ends_with(topic.ending)) return topic.rank;
  }
  constexpr int kHighRange = -10;  // only where there is no other
  if (has_high_range(stem)) return kHighRange;
  const CsvName meaning = meaning_of(stem);
  return meaning.name.empty() ? -5 : meaning.preference;
}

bool is_without_gravity(const std::string& name) {
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower.starts_with("linear") || lower.starts_with("user");
}

}  // namespace

std::string sensor_of_name(const std::string& name) {
  std::string meaning = meaning_of(stem_of(name)).name;
  meaning = meaning.substr(0, meaning.find('_'));
  return meaning == "pos" ? "" : meaning;
}

bool is_chosen_file(const std::string& name, const CsvOptions& options) {
  return std::ranges::any_of(options.sensors, [&](const std::string& s) {
    return name ==
               s.substr(std::min(s.find('='), s.size() - 1) + (s.find('=') < s.size() ? 1 : 0)) ||
           name == s || stem_of(name) == s;
  });
}

std::vector<NamedFile> files_of_folder(const std::string& path) {
  std::vector<NamedFile> files;
  std::error_code error;
  for (std::filesystem::directory_iterator at(path, error), end; !error && at != end;
       at.increment(error)) {
    std::error_code ignored;
    if (!at->is_regular_file(ignored)) continue;
    files.push_back({at->path().string(), at->path().filename().string()});
    if (files.size() == kMostFiles) break;
  }
  return files;
}

Recording read_several(const std::vector<NamedFile>& files, const std::string& path,
                       const CsvOptions& options) {
  std::vector<NamedFile> order = files;
  std::ranges::sort(order, [&](const NamedFile& a, const NamedFile& b) {
    const auto key = [&](const NamedFile& f) {
      return std::tuple(is_chosen_file(f.name, options) ? 0 : 1, -rank_of(f.name), f.name);
    };
    return key(a) < key(b);
  });
  CsvOptions partial = options;
  partial.require_mag = partial.require_imu = false;
  partial.keep_origin = true;
  std::vector<Recording> parts;
  std::optional<InputError> first_error, whole_error;
  std::vector<std::string> unread;
  bool no_gravity = false, has_acc = false;
  for (const NamedFile& file : order) {
    partial.sensor = sensor_of_name(file.name);
    try {
      Recording part = read_recording(file.path, partial);
      part.name = file.name;
      if (is_without_gravity(file.name) && !part.acc.empty()) {
        part.acc = {};
        no_gravity = true;
      }
      has_acc = has_acc || !part.acc.empty();
      parts.push_back(std::move(part));
    } catch (const MissingSensor&) {
      // a file of something else
    } catch (const InputError& error) {
      const bool named = !partial.sensor.empty() || rank_of(file.name) > 0;
      const std::string where =
          file.path.starts_with("/proc/self/fd/") ? path + "/" + file.name : file.path;
      if (named && !first_error && error.line > 0) {
        first_error.emplace(where, error.line, error.column, error.problem, error.remedy);
      }
      unread.push_back(fmt::format("{} is not read: {}", printable(file.name), error.problem));
    }
  }
  if (no_gravity && !has_acc && options.require_imu) {
    throw InputError(
        path, 0, 0, "the only acceleration is without gravity (linear acceleration)",
        "record the accelerometer itself, too: phyphox calls it Acceleration (with g), "
        "Sensor Logger TotalAcceleration");
  }
  constexpr std::size_t kShown = 3;
  if (unread.size() > kShown) unread.resize(kShown);
  try {
    std::vector<std::string> other_devices;
    parts = of_one_device(std::move(parts), path, options, other_devices);
    Recording out = joined(std::move(parts), path, options);
    out.notes.insert(out.notes.begin(), other_devices.begin(), other_devices.end());
    if (first_error) throw *first_error;
    out.notes.insert(out.notes.end(), unread.begin(), unread.end());
    std::filesystem::path folder(path);
    out.name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
    return out;
  } catch (const MissingSensor& missing) {
    if (first_error) throw *first_error;
    if (unread.empty()) throw;
    throw MissingSensor(path, 0, 0,
                        fmt::format("{} ({})", missing.problem, fmt::join(unread, "; ")),
                        missing.remedy);
  }
}

bool is_folder_of_sensors(const std::string& path) {
  std::set<std::string> sensors;
  for (const NamedFile& file : files_of_folder(path)) sensors.insert(sensor_of_name(file.name));
  return sensors.contains("acc") && sensors.contains("gyr") && sensors.contains("mag");
}

}  // namespace magimu
