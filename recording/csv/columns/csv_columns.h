// SPDX-License-Identifier: BSD-3-Clause
// What a CSV header says: which field holds which quantity. Every quantity has a slot in a row of
// numbers: slot 0 is the time, then three for each vector-valued sensor, then one for each scalar.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/columns/csv_options.h"
#include "recording/data/error.h"

namespace magimu {

struct CsvColumns {
  static constexpr int kIgnored = -1;

  struct Field {
    std::string header;      // as in the file, for messages
    int slot = kIgnored;     // where its number goes
    double unit = 1.0;       // the file's unit in ours
    bool taken_off = false;  // its number is an offset that the device added to the reading of this
                             // slot; it is subtracted (with a negative unit: added)
  };

  char separator = ',';
  std::vector<Field> fields;         // in the file's order
  std::vector<std::string> vectors;  // "acc", "gyr", then the magnetometers by number, then "pos"
  bool has_time = false;             // false: times come from CsvOptions::rate_hz
  bool time_unit_known = false;      // the unit is given by option, or by the header
  std::string time_unit_in_header;   // for messages; empty if an option gave the unit
  bool time_unit_of_name =
      false;             // true: the header names no unit, but has a name that usually has this one
  std::size_t mags = 0;  // vectors[2], ..., vectors[1 + mags] are the magnetometers
  std::vector<std::string> scalars;  // "temp", "current"
  // There is no time, and every line holds one sensor's reading: slot 0 counts the cycles of lines.
  bool counts_cycles = false;
  bool takes_off = false;  // at least one field is subtracted (Field::taken_off)
  std::optional<std::size_t>
      device;  // field with the number of a device: only rows of the first device are read
  std::vector<std::string> notes;  // mappings and ignored columns, in words

  std::size_t vector_slot(std::size_t i) const { return 1 + 3 * i; }
  std::size_t scalar_slot(std::size_t i) const { return 1 + 3 * vectors.size() + i; }
  std::size_t slots() const { return 1 + 3 * vectors.size() + scalars.size(); }
};

// Our name of the quantity that a column header names, in any case of its letters: "Gyro.X" ->
// "gyr_x", "timestamp" -> "t". Empty if it names none.
std::string csv_column_name(std::string_view header);

// Reads the header line `text`, which is line `line` of `file`. InputError if a needed column is
// missing, or two claim the same quantity.
CsvColumns read_csv_header(std::string_view text, const std::string& file, long line,
                           const CsvOptions& options);
// The same for a header that has been split into fields already.
CsvColumns read_csv_header(const std::vector<std::string>& headers, char separator,
                           const std::string& file, long line, const CsvOptions& options);

// A file without one of the needed sensors: perhaps a part of a recording. A caller that has the
// other files catches this and joins them (several_files.h).
class MissingSensor : public InputError {
 public:
  using InputError::InputError;
};

// The text without the spaces and tabs around it.
std::string_view csv_trimmed(std::string_view text);

}  // namespace magimu
