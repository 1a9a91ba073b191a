// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/value_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/words.h"

namespace magimu {
namespace {

// A reading falls at half of its steps: that none of 20 does is chance once in a million times.
constexpr std::size_t kLeastSteps = 20;

// From one row of a sensor to its next one.
struct Steps {
  std::size_t all = 0, falls = 0, rises = 0;
};

Steps steps_of(const NumberColumn& column) {
  Steps steps;
  for (const std::vector<double>& numbers : column.of_sensor) {
    for (std::size_t i = 1; i < numbers.size(); ++i) {
      ++steps.all;
      steps.falls += numbers[i] < numbers[i - 1] ? 1 : 0;
      steps.rises += numbers[i] > numbers[i - 1] ? 1 : 0;
    }
  }
  return steps;
}

// An accuracy, a status, a flag: few different numbers, all whole and small. Android's accuracies
// go from -1 to 3, a battery's and a confidence's percentages to 100, a byte's to 255.
bool is_status(const NumberColumn& column) {
  constexpr std::size_t kMostStates = 8;
  constexpr double kLargestState = 255.0;
  std::set<double> states;
  for (const std::vector<double>& numbers : column.of_sensor) {
    for (const double number : numbers) {
      if (number != std::round(number) || std::abs(number) > kLargestState) return false;
      states.insert(number);
      if (states.size() > kMostStates) return false;
    }
  }
  return true;
}

// A temperature, a voltage: whichever sensor's row it stands in, its numbers are in the same range.
// An axis of another sensor has another unit.
bool is_alike_for_all_sensors(const NumberColumn& column) {
  constexpr double kShared = 0.5;  // of the range of all
  double low = -HUGE_VAL, high = HUGE_VAL, lowest = HUGE_VAL, highest = -HUGE_VAL;
  std::size_t sensors = 0;
  for (const std::vector<double>& numbers : column.of_sensor) {
    if (numbers.empty()) continue;
    ++sensors;
    const auto [least, most] = std::ranges::minmax_element(numbers);
    low = std::max(low, *least);
    high = std::min(high, *most);
    lowest = std::min(lowest, *least);
    highest = std::max(highest, *most);
  }
  return sensors > 1 && high - low >= kShared * (highest - lowest);
}

bool is_named_otherwise(const NumberColumn& column) {
  const std::string words = plain_words(column.name);
  return csv_name(column.name).name == "temp" || csv_name(column.name).name == "t" ||
         is_other_quantity(words) || words == "status";
}

using Columns = std::vector<const NumberColumn*>;

// Takes those away, unless too few would be left: then the rule is wrong for this file.
template <class Rule>
void take_away(Columns& columns, std::size_t least, const Rule& rule) {
  Columns left;
  for (const NumberColumn* column : columns) {
    if (!rule(*column)) left.push_back(column);
  }
  if (left.size() >= least) columns = std::move(left);
}

// "x", "acc_y", "Z (uT)"; "value_x"; numbers from 0 or from 1, where there is a whole set of them.
std::vector<std::size_t> axes_by_name(const std::vector<NumberColumn>& columns) {
  std::vector<const NumberColumn*> axes;
  for (const NumberColumn& column : columns) {
    if (!csv_name("acc_" + column.name).name.empty()) axes.push_back(&column);
  }
  if (axes.size() == 3) {  // "z,y,x" (Sensor Logger)
    std::ranges::sort(axes, {},
                      [](const NumberColumn* c) { return csv_name("acc_" + c->name).name.back(); });
    return {axes[0]->field, axes[1]->field, axes[2]->field};
  }
  std::map<std::string, std::map<char, std::size_t>> groups;  // by what is before the last letter
  for (const NumberColumn& column : columns) {
    std::string words = plain_words(column.name);
    words.resize(std::min(words.find_first_of("(["), words.size()));
    while (words.ends_with(' ')) words.pop_back();
    if (words.empty()) continue;
    groups[words.substr(0, words.size() - 1)].emplace(words.back(), column.field);
  }
  for (const std::array<char, 3>& letters :
       {std::array<char, 3>{'x', 'y', 'z'}, {'0', '1', '2'}, {'1', '2', '3'}}) {
    for (const auto& group : groups) {
      const std::map<char, std::size_t>& fields = group.second;
      if (!std::ranges::all_of(letters, [&](char c) { return fields.contains(c); })) continue;
      return {fields.at(letters[0]), fields.at(letters[1]), fields.at(letters[2])};
    }
  }
  return {};
}

}  // namespace

bool is_clock_or_counter(const NumberColumn& column) {
  constexpr double kMostFalls = 0.01;  // a clock may be set back, a counter may roll over
  const Steps steps = steps_of(column);
  return steps.all >= kLeastSteps && steps.rises > 0 &&
         double(steps.falls) <= kMostFalls * double(steps.all);
}

bool falls_as_readings_do(const NumberColumn& column) {
  const Steps steps = steps_of(column);
  return steps.all >= kLeastSteps && 4 * steps.falls > steps.all;
}

std::vector<std::size_t> value_fields(const std::vector<NumberColumn>& columns, std::size_t count) {
  if (columns.size() < count) return {};
  if (count == 3) {
    if (std::vector<std::size_t> named = axes_by_name(columns); !named.empty()) return named;
  }
  Columns left;
  for (const NumberColumn& column : columns) left.push_back(&column);
  take_away(left, count, [](const NumberColumn& c) { return !c.every_sensor_has_it; });
  take_away(left, count, is_named_otherwise);
  take_away(left, count, is_clock_or_counter);
  take_away(left, count, is_status);
  if (left.size() > count) take_away(left, count, is_alike_for_all_sensors);
  std::size_t first = 0;
  for (std::size_t i = 0; i + count <= left.size(); ++i) {
    if (left[i + count - 1]->field - left[i]->field != count - 1) continue;
    first = i;
    break;
  }
  if (count == 1) first = left.size() - 1;  // the value stands behind what it is of
  std::vector<std::size_t> fields;
  for (std::size_t i = 0; i < count; ++i) fields.push_back(left[first + i]->field);
  return fields;
}

}  // namespace magimu
