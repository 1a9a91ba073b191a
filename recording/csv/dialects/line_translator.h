// SPDX-License-Identifier: BSD-3-Clause
// Translates lines of other dialects, one by one, to rows that CsvParser reads fast: numbers with a
// decimal point, one separator, the same number of fields in each.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

class LineTranslator {
 public:
  virtual ~LineTranslator() = default;
  // The row, valid until the next call; nothing for a line that holds no sample.
  virtual std::optional<std::string_view> row(std::string_view line) = 0;
};

// Makes one blank of several, points of decimal commas. Removes quotation marks, separators between
// them, and marks between groups of three digits.
std::shared_ptr<LineTranslator> plain_numbers_translator(char separator, bool decimal_comma,
                                                         char group_mark = 0);

// Joins two fields, seconds and their fraction, to one. `digits`: of the fraction; 9 for
// nanoseconds (ROS).
std::shared_ptr<LineTranslator> fraction_translator(char separator, std::size_t seconds,
                                                    std::size_t fraction, std::size_t digits);

// Long format: a row is one sensor's reading at one time.
struct LongFormat {
  char separator = ',';
  bool decimal_comma = false;
  std::optional<std::size_t> time;  // field of the time; none: rows have no time
  std::size_t word = 0;             // field of the word that names the sensor
  std::vector<std::size_t> values;  // fields of the numbers
  std::vector<std::string>
      words;               // of the sensors, in the order of their numbers in the row that is made
  bool own_times = false;  // in the row each sensor has its own time before its numbers
  // Our names ("acc_x") where a word is one component's: a row is made of a sensor's lines. Empty:
  // a line is a row.
  std::vector<std::string> components;
};
std::shared_ptr<LineTranslator> long_format_translator(LongFormat format);

// "ax:0.4, ay=1.05", "Accel X: 0.1 Y: 0.2 m/s^2", {"acc":[1,2,3]}: one number of a line, with the
// words before it.
struct LabelledNumber {
  std::string label;          // "ax", "Accel X", "acc"
  std::size_t component = 0;  // of several numbers behind one label
  std::string_view text;      // the number
  std::string unit;           // behind it or in brackets before it, where a known one is there
};
std::vector<LabelledNumber> labelled_numbers(std::string_view line);

struct LabelledField {
  std::string label;
  std::size_t component = 0;
};
// Rows with these fields, the time of the day before the line ("12:00:01.5 -> ...") in front of
// them if with_clock.
std::shared_ptr<LineTranslator> labelled_translator(std::vector<LabelledField> fields,
                                                    bool with_clock);

// Takes a time of the day, and what separates it from the rest, from the beginning of a line;
// nothing if it begins otherwise.
std::optional<std::string_view> leading_clock(std::string_view& line);

}  // namespace magimu
