// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv_names.h"

#include <algorithm>

#include "recording/units.h"

namespace magimu {
namespace {

// Words as plain_letters leaves them, with '_' for every separator.
struct Word {
  std::string_view word, name;
  int preference = 0;
  std::string_view unit = {};  // where the word implies one
};

constexpr Word kScalars[] = {
    {"t", "t"},
    {"time", "t"},
    {"timestamp", "t"},
    {"seconds", "t"},
    {"seconds_elapsed", "t", 1},  // Sensor Logger; its "time" is in ns since 1970
    {"time_since_start", "t", 1},
    {"temp", "temp"},
    {"temperature", "temp"},
    {"current", "current"},
    {"current_a", "current"},
};

constexpr Word kVectors[] = {
    {"acc", "acc"},
    {"accel", "acc"},
    {"accelerometer", "acc"},
    {"acceleration", "acc", 1},               // phyphox: with gravity
    {"totalacceleration", "acc", 3},          // Sensor Logger: with gravity
    {"accelerometeruncalibrated", "acc", 2},  // Sensor Logger: with gravity
    {"gf", "acc", 3, "g"},                    // Physics Toolbox; its ax is without gravity
    {"linear_acceleration", "acc", -1},       // ROS: with gravity, phyphox: without
    {"a", "acc"},
    {"gyr", "gyr"},
    {"gyro", "gyr"},
    {"gyroscope", "gyr"},
    {"gyroscopeuncalibrated", "gyr", 1},
    {"angular_velocity", "gyr"},
    {"g", "gyr"},
    {"w", "gyr"},
    {"mag", "mag"},
    {"magnetometer", "mag"},
    {"magnetometeruncalibrated", "mag", 1},
    {"magnetic_field", "mag"},
    {"m", "mag"},
    {"b", "mag"},
    {"pos", "pos"},
    {"position", "pos"},
    {"p", "pos"},
};

bool is_separator(char c) { return c == '_' || c == '.' || c == ' ' || c == '-' || c == '/'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

template <class Table>
const Word* find(std::string_view word, const Table& table) {
  const auto* const found = std::ranges::find(table, word, &Word::word);
  return found == std::end(table) ? nullptr : found;
}

CsvName named(const Word& word, std::string name) {
  CsvName out;
  out.name = std::move(name);
  out.preference = word.preference;
  if (!word.unit.empty()) {
    out.unit = unit_in_ours(word.name, word.unit).value_or(1.0);
    out.unit_text = word.unit;
  }
  return out;
}

// The name without a unit, in words of the tables.
CsvName bare_name(std::string_view words) {
  if (const Word* word = find(words, kScalars)) return named(*word, std::string(word->name));
  // A vector's component: sensor, number, axis, with or without separators.
  if (words.empty() || words.back() < 'x' || words.back() > 'z') return {};
  const char axis = words.back();
  const auto drop_separator = [&words] {
    if (words.ends_with('_')) words.remove_suffix(1);
  };
  words.remove_suffix(1);
  drop_separator();
  std::string number;
  for (; !words.empty() && is_digit(words.back()); words.remove_suffix(1)) {
    number.insert(number.begin(), words.back());
  }
  if (!number.empty()) drop_separator();
  const Word* word = find(words, kVectors);
  for (const std::string_view prefix : {"imu_", "field_", "raw_"}) {
    if (word == nullptr && words.starts_with(prefix)) {
      word = find(words.substr(prefix.size()), kVectors);
    }
  }
  if (word == nullptr) return {};
  if (!number.empty()) {
    if (word->name != "mag" || number.size() > 6) return {};
    number = std::to_string(std::stoi(number));  // mag01 is mag1
  }
  return named(*word, std::string(word->name) + number + '_' + axis);
}

std::string quantity_of(const std::string& name) { return name.substr(0, name.find('_')); }

void set_unit(CsvName& name, std::string_view text) {
  name.unit_text = text;
  if (name.name == "temp" || name.name == "current") return;
  const auto unit = unit_in_ours(quantity_of(name.name), text);
  name.unknown_unit = !unit.has_value();
  name.unit = unit.value_or(1.0);
}

}  // namespace

CsvName csv_name(std::string_view header) {
  std::string words = plain_letters(header);
  // "name (unit)" or "name [unit]"
  std::string in_brackets;
  const char close = words.empty() ? ' ' : words.back();
  if (close == ')' || close == ']') {
    const std::size_t open = words.rfind(close == ')' ? '(' : '[');
    if (open == std::string::npos) return {};
    in_brackets = words.substr(open + 1, words.size() - open - 2);
    words.resize(open);
    while (!words.empty() && is_separator(words.back())) words.pop_back();
  }
  std::ranges::replace_if(words, is_separator, '_');
  CsvName name = bare_name(words);
  if (!in_brackets.empty() && !name.name.empty()) set_unit(name, in_brackets);
  if (!name.name.empty() || !in_brackets.empty()) return name;
  // "name_unit"; a unit may itself have a separator ("deg_s").
  for (std::size_t at = words.rfind('_'); at != std::string::npos && at > 0;
       at = words.rfind('_', at - 1)) {
    name = bare_name(std::string_view(words).substr(0, at));
    if (name.name.empty() || name.name == "temp" || name.name == "current") continue;
    const std::string text = words.substr(at + 1);
    if (!unit_in_ours(quantity_of(name.name), text) || is_digit(text.front())) return {};
    set_unit(name, text);
    return name;
  }
  return {};
}

}  // namespace magimu
