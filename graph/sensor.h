// SPDX-License-Identifier: BSD-3-Clause
// The kinds of sensors, with their short names (of files and JSON), their names in sentences and
// their units.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace magimu {

// The last two are no sensors: rows of a graph's linear system may belong to them
// (calibration/motion/sensor_rows.h). kReach: weak measurements of the position of a hand-held
// sensor, or of the velocity of a travelling one. kNone: priors on parameters.
enum class Sensor { kAcc = 0, kGyr = 1, kMag = 2, kReach = 3, kNone = 4 };

// Those that are sensors.
inline constexpr std::array kSensors = {Sensor::kAcc, Sensor::kGyr, Sensor::kMag};
// Entries of an array with one for each but kNone.
inline constexpr std::size_t kMeasuring = 4;

// "acc", "gyr", "mag".
inline std::string to_string(Sensor sensor) {
  constexpr const char* kNames[] = {"acc", "gyr", "mag", "reach", "none"};
  return kNames[std::size_t(sensor)];
}

// The sensor with this name: "acc", "gyr"; all other names are magnetometers' ("mag", "mag2").
constexpr Sensor sensor_named(std::string_view name) {
  return name == "acc" ? Sensor::kAcc : name == "gyr" ? Sensor::kGyr : Sensor::kMag;
}

// "accelerometer", "gyroscope", "magnetometer".
constexpr const char* in_words(Sensor sensor) {
  return sensor == Sensor::kAcc   ? "accelerometer"
         : sensor == Sensor::kGyr ? "gyroscope"
                                  : "magnetometer";
}

// The same of a name; names of an array's magnetometers ("mag2") stay as they are.
inline std::string in_words(std::string_view name) {
  const Sensor sensor = sensor_named(name);
  return sensor == Sensor::kMag && name != "mag" ? std::string(name) : in_words(sensor);
}

// "m/s^2", "rad/s", "uT".
constexpr const char* unit_of(Sensor sensor) {
  return sensor == Sensor::kAcc ? "m/s^2" : sensor == Sensor::kGyr ? "rad/s" : "uT";
}

}  // namespace magimu
