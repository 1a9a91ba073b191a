// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/axes_of_calibration.h"

#include <fmt/format.h>

#include <map>
#include <optional>

#include "recording/data/axes.h"
#include "recording/data/error.h"

namespace magimu::apps {
namespace {

using Turns = std::map<std::string, std::string>;

const std::string kAsTheyCome = "x,y,z";

// The turns of each sensor; several turns of one sensor are combined.
Turns turns_of(const ReadingOptions& options) {
  std::map<std::string, Matrix3> all;
  for (const auto& [sensor, axes] : options.turns()) {
    Matrix3& turn = all.try_emplace(sensor, Matrix3::Identity()).first->second;
    turn = axes * turn;
  }
  Turns out;
  for (const auto& [sensor, turn] : all) out[sensor] = axes_text(turn);
  return out;
}

std::string turn_of(const Turns& turns, const std::string& sensor) {
  const auto it = turns.find(sensor);
  return it == turns.end() ? kAsTheyCome : it->second;
}

std::string in_words(const std::string& sensor, const std::string& axes) {
  return axes == kAsTheyCome ? fmt::format("with {} as it comes", sensor)
                             : fmt::format("with --axes {}={}", sensor, axes);
}

// Empty where the file has no such field.
std::optional<Turns> turns_in(const nlohmann::ordered_json& file) {
  const auto it = file.find("axes");
  if (!file.is_object() || it == file.end() || !it->is_object()) return std::nullopt;
  Turns out;
  for (const auto& [sensor, axes] : it->items()) {
    if (axes.is_string()) out[sensor] = axes.get<std::string>();
  }
  return out;
}

}  // namespace

nlohmann::ordered_json axes_json(const ReadingOptions& options) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const auto& [sensor, axes] : turns_of(options)) {
    if (axes != kAsTheyCome) out[sensor] = axes;
  }
  return out;
}

std::map<std::string, std::string> axes_in(const nlohmann::ordered_json& file) {
  return turns_in(file).value_or(Turns{});
}

void check_same_axes(const nlohmann::ordered_json& file, const std::string& path,
                     const ReadingOptions& options) {
  const std::optional<Turns> made = turns_in(file);
  if (!made) return;
  const Turns now = turns_of(options);
  Turns all = *made;
  all.insert(now.begin(), now.end());
  for (const auto& [sensor, axes] : all) {
    const std::string then = turn_of(*made, sensor), here = turn_of(now, sensor);
    // If the user says explicitly that a sensor comes in the device's axes, the turn was made
    // before.
    const bool said = now.contains(sensor) && here == kAsTheyCome;
    if (then == here || said) continue;
    throw InputError(
        path, 0, 0,
        fmt::format("this calibration was made {}, and the recording is read {}",
                    in_words(sensor, then), in_words(sensor, here)),
        then == kAsTheyCome
            ? fmt::format("leave --axes {} away", sensor)
            : fmt::format("give --axes {}={}, or, where the recording is in the device's axes "
                          "already, --axes {}={}",
                          sensor, then, sensor, kAsTheyCome));
  }
}

}  // namespace magimu::apps
