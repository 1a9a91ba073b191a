// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/csv_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

#include "recording/csv/columns/words.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

// Preference of a sensor's word behind other words ("imu_data_acc"): it is less sure than the word
// alone.
constexpr int kBehindOthers = -4;
// Characters. Longer headers are not looked at: the search takes the square of their length.
constexpr std::size_t kLongestName = 256;
// Preference of readings as measured over those that the device has corrected.
constexpr int kUncalibrated = 2;

bool is_separator(char c) { return std::string_view("_. -/:").find(c) != std::string_view::npos; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_axis(char c) { return c >= 'x' && c <= 'z'; }

CsvName named(const CsvWord& word, std::string name, int less = 0) {
  CsvName out;
  out.name = std::move(name);
  out.preference = word.preference + less;
  if (!word.unit.empty()) {
    out.unit = unit_in_ours(word.name, word.unit).value_or(1.0);
    out.unit_text = word.unit;
    out.unit_of_word = true;
  }
  return out;
}

// The part behind each '_', the longest first, as long as no word before it makes another quantity
// of it: "imu_data_angular_velocity" -> "data_angular_velocity", "angular_velocity", "velocity".
template <class Use>
void for_each_tail(std::string_view words, const Use& use) {
  constexpr std::size_t kShortest = 3;  // "a" or "g" alone means too little behind other words
  while (true) {
    const std::size_t at = words.find('_');
    if (at == std::string_view::npos || is_other_quantity(words.substr(0, at))) return;
    words.remove_prefix(at + 1);
    if (words.size() < kShortest || use(words)) return;
  }
}

struct SensorWord {
  const CsvWord* word = nullptr;
  std::string_view unit = {};  // "m_s2" of "accelerometer_m_s2"
  int less = 0;
  bool uncalibrated = false;
};

SensorWord sensor_and_unit(std::string_view words) {
  if (const CsvWord* word = vector_word(words)) return {word};
  for (std::size_t at = words.rfind('_'); at != std::string_view::npos && at > 0;
       at = words.rfind('_', at - 1)) {
    const CsvWord* const word = vector_word(words.substr(0, at));
    const std::string_view unit = words.substr(at + 1);
    if (word != nullptr && !is_digit(unit.front()) && unit_in_ours(word->name, unit)) {
      return {word, unit};
    }
  }
  return {};
}

// "mag_uncalibrated", "uncal_mag" -> "mag"; empty for any other.
std::string_view without_uncalibrated(std::string_view words) {
  for (const std::string_view word : {"uncalibrated", "uncal"}) {
    std::string_view rest = words;
    if (rest.ends_with(word)) {
      rest.remove_suffix(word.size());
      if (rest.ends_with('_')) rest.remove_suffix(1);
      return rest;
    }
    if (rest.starts_with(word)) {
      rest.remove_prefix(word.size());
      if (rest.starts_with('_')) rest.remove_prefix(1);
      return rest;
    }
  }
  return {};
}

SensorWord sensor_of(std::string_view words) {
  SensorWord sensor = sensor_and_unit(words);
  if (const std::string_view rest = without_uncalibrated(words); !rest.empty()) {
    sensor = sensor_of(rest);
    sensor.less += kUncalibrated;
    sensor.uncalibrated = true;
    return sensor;
  }
  for (const std::string_view prefix : {"imu_", "field_", "raw_"}) {
    if (sensor.word == nullptr && words.starts_with(prefix)) {
      sensor = sensor_and_unit(words.substr(prefix.size()));
    }
  }
  if (sensor.word == nullptr && words.ends_with("_sensor")) {  // "Accel Sensor X"
    sensor = sensor_of(words.substr(0, words.rfind('_')));
  }
  if (sensor.word != nullptr) return sensor;
  for_each_tail(words, [&sensor](std::string_view tail) {
    sensor = sensor_and_unit(tail);
    sensor.less = kBehindOthers;
    return sensor.word != nullptr;
  });
  return sensor;
}

std::string quantity_of(const std::string& name) { return name.substr(0, name.find('_')); }

// "time (+01:00)", "loggingTime(txt)", "Time (HH:mm:ss)": how times are written, no unit.
bool is_way_to_write_times(std::string_view text) {
  constexpr std::string_view kWays[] = {"txt",     "utc",      "gmt",  "local", "iso",
                                        "iso8601", "iso 8601", "tick", "ticks"};
  const bool zone = text.size() > 1 && (text[0] == '+' || text[0] == '-') && is_digit(text[1]);
  return zone || text.find("hh") != std::string_view::npos ||
         std::ranges::find(kWays, text) != std::end(kWays);
}

// "T [degC]" is a temperature.
bool is_unit_of_temperature(std::string_view text) {
  constexpr std::string_view kDegrees[] = {"c", "degc", "deg c", "'c", "celsius", "k", "degf"};
  return std::ranges::find(kDegrees, text) != std::end(kDegrees);
}

void set_unit(CsvName& name, std::string_view text) {
  if (name.name == "t" && is_way_to_write_times(text)) return;
  if (name.name == "t" && is_unit_of_temperature(text)) name.name = "temp";
  if (name.name != "t" && says_no_unit(text)) return;
  name.unit_text = text;
  name.unit_of_word = false;
  if (name.name == "temp" || name.name == "current") return;
  const auto unit = unit_in_ours(quantity_of(name.name), text);
  name.unknown_unit = !unit.has_value();
  name.unit = unit.value_or(1.0);
}

// "ACC.X 1" (Delsys): the sensor's number behind the axis and a space, taken off the words.
// ("acc_x_5" is another quantity, such as one of several values of a window.)
std::string take_number_behind(std::string& words) {
  const std::size_t last = words.find_last_not_of("0123456789");
  if (last == std::string::npos || last < 2 || last + 1 == words.size()) return {};
  if (words[last] != ' ' || !is_axis(words[last - 1]) || !is_separator(words[last - 2])) return {};
  std::string number = words.substr(last + 1);
  words.resize(last);
  return number;
}

// A vector's component: sensor, number, axis, with or without separators; or the axis first.
CsvName component(std::string_view words, const std::string& number_behind) {
  if (words.ends_with("_axis")) words.remove_suffix(5);
  if (words.empty()) return {};
  char axis = words.back();
  if (is_axis(axis)) {
    words.remove_suffix(1);
  } else if (axis = words.front(); is_axis(axis) && words.size() > 3) {
    words.remove_prefix(1);
    if (words.starts_with("_axis_")) words.remove_prefix(5);
    if (words.starts_with('_')) words.remove_prefix(1);
  } else {
    return {};
  }
  const auto drop_separator = [&words] {
    if (words.ends_with('_')) words.remove_suffix(1);
  };
  drop_separator();
  std::string number;
  SensorWord sensor = sensor_of(words);  // "accelerometer_m_s2" ends in a unit, not in a number
  for (; sensor.word == nullptr && !words.empty() && is_digit(words.back());
       words.remove_suffix(1)) {
    number.insert(number.begin(), words.back());
  }
  if (!number.empty()) drop_separator();
  if (sensor.word == nullptr) sensor = sensor_of(words);
  if (sensor.word == nullptr) return {};
  if (number.empty() && sensor.word->name == "mag") number = number_behind;
  if (!number.empty()) {
    if (sensor.word->name != "mag" || number.size() > 6) return {};
    number = std::to_string(std::stoi(number));  // mag01 is mag1
  }
  CsvName name =
      named(*sensor.word, std::string(sensor.word->name) + number + '_' + axis, sensor.less);
  if (!sensor.unit.empty()) set_unit(name, sensor.unit);
  name.uncalibrated = sensor.uncalibrated;
  return name;
}

// "roll rate", "PitchRate", "YawRate": the rates about x, y and z.
CsvName rate_by_name(std::string_view words) {
  constexpr std::pair<std::string_view, char> kRates[] = {
      {"roll", 'x'}, {"pitch", 'y'}, {"yaw", 'z'}};
  for (const auto& [word, axis] : kRates) {
    if (!words.starts_with(word)) continue;
    const std::string_view rest = words.substr(word.size());
    if (rest != "rate" && rest != "_rate") continue;
    CsvName name;
    name.name = std::string("gyr_") + axis;
    name.preference = kBehindOthers;  // a gyroscope that the file has, too, comes first
    return name;
  }
  return {};
}

// The name without a unit, in words of the tables.
CsvName bare_name(std::string_view words, const std::string& number_behind = {}) {
  if (const CsvWord* word = scalar_word(words)) return named(*word, std::string(word->name));
  CsvName name = rate_by_name(words);  // before the y of "yaw" is taken for an axis
  if (name.name.empty()) name = component(words, number_behind);
  if (!name.name.empty()) return name;
  for_each_tail(words, [&name](std::string_view tail) {
    const CsvWord* const word = scalar_word(tail);
    const bool stamp = tail == "stamp" || tail == "header_stamp" || tail == "timestamp" ||
                       tail == "timestamp_unix";
    if (word != nullptr && stamp) name = named(*word, std::string(word->name), kBehindOthers);
    return !name.name.empty();
  });
  return name;
}

}  // namespace

CsvName csv_name(std::string_view header) {
  if (header.size() > kLongestName) return {};
  std::string words = plain_words(header);
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
  // "B_x / \xC2\xB5T": quantity / unit, as the SI brochure recommends.
  if (const std::size_t slash = words.rfind(" / "); in_brackets.empty() && slash != words.npos) {
    const std::string unit = words.substr(slash + 3);
    const bool known = std::ranges::any_of(
        std::initializer_list<const char*>{"acc", "gyr", "mag", "t"},
        [&unit](const char* quantity) { return unit_in_ours(quantity, unit).has_value(); });
    if (known) {
      in_brackets = unit;
      words.resize(slash);
    }
  }
  const std::string number_behind = take_number_behind(words);
  std::ranges::replace_if(words, is_separator, '_');
  words.erase(
      std::unique(words.begin(), words.end(), [](char a, char b) { return a == '_' && b == '_'; }),
      words.end());
  // "%time", "__time", "/imu/..."
  words.erase(0, std::min(words.find_first_not_of("%$#_"), words.size()));
  while (words.ends_with('_')) words.pop_back();
  if (words.ends_with("_cal")) words.resize(words.size() - 4);  // Shimmer: in units
  CsvName name = bare_name(words, number_behind);
  if (!in_brackets.empty() && !name.name.empty()) set_unit(name, in_brackets);
  if (!name.name.empty() || !in_brackets.empty()) return name;
  // "name_unit"; a unit may itself have a separator ("deg_s").
  for (std::size_t at = words.rfind('_'); at != std::string::npos && at > 0;
       at = words.rfind('_', at - 1)) {
    std::string_view front = std::string_view(words).substr(0, at);
    if (front.ends_with("_in")) front.remove_suffix(3);  // "time since start in ms"
    name = bare_name(front);
    if (name.name.empty() || name.name == "temp" || name.name == "current") continue;
    const std::string text = words.substr(at + 1);
    if (!unit_in_ours(quantity_of(name.name), text) || is_digit(text.front())) return {};
    set_unit(name, text);
    return name;
  }
  return {};
}

std::string csv_time_of(std::string_view header) {
  if (header.size() > kLongestName) return {};
  std::string words = plain_words(header);
  for (const char open : {'(', '['}) words.resize(std::min(words.find(open), words.size()));
  while (!words.empty() && is_separator(words.back())) words.pop_back();
  std::ranges::replace_if(words, is_separator, '_');
  for (std::size_t at = words.find('_'); at != std::string::npos; at = words.find('_', at + 1)) {
    const std::string front = words.substr(0, at), back = words.substr(at + 1);
    for (const auto& [sensor, time] : {std::pair(front, back), std::pair(back, front)}) {
      const CsvWord* const t = scalar_word(time);
      const CsvWord* const its = vector_word(sensor);
      if (t != nullptr && t->name == "t" && its != nullptr && its->name != "pos") {
        return std::string(its->name);
      }
    }
  }
  return {};
}

namespace {

// "Accelerometer [m/s2]", "1", "2" (GoPro), or nothing above the other two: a sensor's name stands
// above the first of its three columns.
void name_axes_behind_a_sensor(std::vector<std::string>& headers) {
  for (std::size_t i = 0; i + 2 < headers.size(); ++i) {
    const std::string& second = headers[i + 1];
    const std::string& third = headers[i + 2];
    if (!(second.empty() && third.empty()) && !(second == "1" && third == "2")) continue;
    const std::size_t bracket = std::min(headers[i].find_first_of("(["), headers[i].size());
    std::string word = headers[i].substr(0, bracket);
    while (word.ends_with(' ')) word.pop_back();
    const std::string unit = headers[i].substr(bracket);
    const CsvName first = csv_name(fmt::format("{}_x {}", word, unit));
    if (word.size() < 3 || first.name.empty() || first.name.starts_with("pos")) continue;
    if (!csv_name(headers[i]).name.empty()) continue;  // "Acc X"
    for (std::size_t axis = 0; axis < 3; ++axis) {
      headers[i + axis] = fmt::format("{}_{} {}", word, "xyz"[axis], unit);
    }
  }
}

}  // namespace

std::vector<std::string> with_axes_for_numbers(std::vector<std::string> headers) {
  name_axes_behind_a_sensor(headers);
  struct Group {
    std::string front, back;  // before and behind the number
    std::array<std::size_t, 4> at{};
    std::array<std::size_t, 4> count{};
  };
  std::vector<Group> groups;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    const std::string& header = headers[i];
    std::size_t digit = header.size();
    if (digit > 0 && header.back() == ')') digit = std::min(header.rfind('('), digit);
    while (digit > 0 && (header[digit - 1] == ' ' || header[digit - 1] == ']')) --digit;
    if (digit < 2 || !is_digit(header[digit - 1]) || is_digit(header[digit - 2])) continue;
    const std::string front = header.substr(0, digit - 1);
    std::string back = header.substr(digit);
    if (back.starts_with(']')) back.erase(0, 1);
    auto group = std::ranges::find_if(
        groups, [&](const Group& g) { return g.front == front && g.back == back; });
    if (group == groups.end()) group = groups.insert(groups.end(), {front, back, {}, {}});
    const auto number = static_cast<std::size_t>(header[digit - 1] - '0');
    if (number > 3) {
      group->count.fill(2);  // more than three
      continue;
    }
    group->at[number] = i;
    ++group->count[number];
  }
  for (const Group& group : groups) {
    const bool from_0 = group.count == std::array<std::size_t, 4>{1, 1, 1, 0};
    if (!from_0 && group.count != std::array<std::size_t, 4>{0, 1, 1, 1}) continue;
    std::string front = group.front;
    while (!front.empty() && (front.back() == '[' || is_separator(front.back()))) front.pop_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = front + '_' + "xyz"[axis] + group.back;
      if (csv_name(name).name.empty()) break;
      headers[group.at[axis + (from_0 ? 0 : 1)]] = name;
    }
  }
  return headers;
}

}  // namespace magimu
