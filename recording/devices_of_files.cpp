// SPDX-License-Identifier: BSD-3-Clause
#include "recording/devices_of_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "graph/sensor.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/several_files.h"

namespace magimu {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// The words of a file's name before the one that names its sensor, without numbers, dates and times
// of the day, which may be another one for each file of a device.
std::vector<std::string> words_of_device(const std::string& name) {
  constexpr std::string_view kSeparators = "_- .";
  std::string front = std::filesystem::path(name).stem().string();
  if (const std::string sensor = sensor_of_name(name); !sensor.empty()) {
    // The shortest end that names the sensor.
    std::size_t at = front.size();
    do {
      at = at == 0 ? std::string::npos : front.find_last_of(kSeparators, at - 1);
    } while (at != std::string::npos && sensor_of_name(front.substr(at + 1) + ".csv") != sensor);
    front.resize(at == std::string::npos ? 0 : at);
  }
  std::vector<std::string> words(1);
  for (const char c : front) {
    if (kSeparators.find(c) != std::string_view::npos) {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  std::erase_if(words, [](const std::string& word) {
    return std::ranges::all_of(word, [](char c) { return is_digit(c) || c == 'T' || c == 'Z'; });
  });
  return words;
}

// "C8F4", "D422CD000123", "IMU1": a number of a device in it, or hexadecimal digits alone.
bool is_of_a_device(const std::string& word) {
  constexpr std::size_t kShortestAddress = 4;
  const bool hexadecimal = std::ranges::all_of(
      word, [](char c) { return is_digit(c) || (c >= 'A' && c <= 'F') || (c >= 'a' && c <= 'f'); });
  return std::ranges::any_of(word, is_digit) || (hexadecimal && word.size() >= kShortestAddress);
}

bool differ_in_one_device_word(const std::vector<std::string>& a,
                               const std::vector<std::string>& b) {
  if (a.size() != b.size()) return false;
  std::size_t different = 0, shared = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == b[i]) {
      ++shared;
      continue;
    }
    ++different;
    if (!is_of_a_device(a[i]) || !is_of_a_device(b[i])) return false;
    shared += a[i].front() == b[i].front() ? 1 : 0;  // "IMU1" and "IMU2"
  }
  return different == 1 && shared > 0;
}

struct Device {
  std::vector<std::string> words;
  std::set<std::string> sensors;
  std::vector<std::size_t> parts;
  bool chosen = false;
};

std::set<std::string> sensors_of(const Recording& part) {
  std::set<std::string> sensors;
  if (!part.acc.empty()) sensors.insert("acc");
  if (!part.gyr.empty()) sensors.insert("gyr");
  if (!part.mag.empty()) sensors.insert("mag");
  return sensors;
}

[[noreturn]] void refuse_two_devices(const std::string& path, const std::vector<Recording>& parts,
                                     const Device& device, const std::string& sensor,
                                     const Device& other) {
  std::vector<std::string> has, choice;
  for (const std::string& its : device.sensors) has.emplace_back(in_words(sensor_named(its)));
  for (const Device* d : {&device, &other}) {
    for (const std::size_t i : d->parts) {
      choice.push_back("--sensor " + shell_word(parts[i].name));
    }
  }
  throw InputError(
      path, 0, 0,
      fmt::format("of one device there is the {} ({}), but the {} is of another one ({})",
                  fmt::join(has, " and the "), printable(parts[device.parts.front()].name),
                  in_words(sensor_named(sensor)), printable(parts[other.parts.front()].name)),
      fmt::format("give the files of one device in a folder of their own; if these are of one: {}",
                  fmt::join(choice, " ")));
}

}  // namespace

bool differ_in_device(const std::string& name, const std::string& other) {
  return differ_in_one_device_word(words_of_device(name), words_of_device(other));
}

std::vector<Recording> of_one_device(std::vector<Recording> parts, const std::string& path,
                                     const CsvOptions& options, std::vector<std::string>& notes) {
  std::vector<Device> devices;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::set<std::string> sensors = sensors_of(parts[i]);
    if (sensors.empty()) continue;
    std::vector<std::string> words = words_of_device(parts[i].name);
    auto device = std::ranges::find(devices, words, &Device::words);
    if (device == devices.end()) {
      device = devices.insert(devices.end(), {std::move(words), {}, {}, false});
    }
    device->sensors.insert(sensors.begin(), sensors.end());
    device->parts.push_back(i);
    device->chosen = device->chosen || is_chosen_file(parts[i].name, options);
  }
  if (devices.empty()) return parts;
  const auto taken = std::ranges::max_element(
      devices, {}, [](const Device& d) { return std::pair(d.chosen, d.sensors.size()); });
  std::vector<bool> left_out(parts.size(), false);
  std::set<std::string> there;
  for (const Device& device : devices) {
    const bool rival = &device != &*taken && differ_in_one_device_word(device.words, taken->words);
    for (const std::size_t i : device.parts) {
      left_out[i] = rival && !is_chosen_file(parts[i].name, options);
      if (!left_out[i]) there.merge(sensors_of(parts[i]));
    }
  }
  for (const Device& device : devices) {
    for (const std::string& sensor : device.sensors) {
      const bool needed = sensor == "mag" ? options.require_mag : options.require_imu;
      if (needed && !there.contains(sensor)) {
        refuse_two_devices(path, parts, *taken, sensor, device);
      }
    }
  }
  std::vector<std::string> names;
  std::vector<Recording> out;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (left_out[i]) {
      names.push_back(printable(parts[i].name));
    } else {
      out.push_back(std::move(parts[i]));
    }
  }
  if (!names.empty()) {
    notes.push_back(
        fmt::format("not used, as their names are another device's: {}; --sensor "
                    "chooses a device by one of its files",
                    fmt::join(names, ", ")));
  }
  return out;
}

}  // namespace magimu
