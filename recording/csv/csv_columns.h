// SPDX-License-Identifier: BSD-3-Clause
// What a CSV header says: which field holds which quantity. Every quantity has a slot in a row of
// numbers: slot 0 is the time, then three for each vector-valued sensor, then one for each scalar.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/csv.h"
#include "recording/data/error.h"

namespace magimu {

struct CsvColumns {
  static constexpr int kIgnored = -1;

  struct Field {
    std::string header;      // as in the file, for messages
    int slot = kIgnored;     // where its number goes
    double unit = 1.0;       // the file's unit in ours
    bool taken_off = false;  // its number was added to the slot's reading: it is taken off again
  };

  char separator = ',';
  std::vector<Field> fields;         // in the file's order
  std::vector<std::string> vectors;  // "acc", "gyr", then the magnetometers by number, then "pos"
  bool has_time = false;             // else CsvOptions::rate_hz makes the times
  bool time_unit_known = false;      // by option, or named in its header
  std::string time_unit_in_header;   // in words, where only the header names it
  bool time_unit_of_name = false;    // ... by a name that usually has it
  std::size_t mags = 0;              // vectors[2], ..., vectors[1 + mags] are the magnetometers
  std::vector<std::string> scalars;  // "temp", "current"
  // There is no time, and every line holds one sensor's reading: slot 0 counts the cycles of lines.
  bool counts_cycles = false;
  bool takes_off = false;             // a field is taken off
  std::optional<std::size_t> device;  // field: the number of a device; the first one's rows count
  std::vector<std::string> notes;     // mappings and ignored columns, in words

  std::size_t vector_slot(std::size_t i) const { return 1 + 3 * i; }
  std::size_t scalar_slot(std::size_t i) const { return 1 + 3 * vectors.size() + i; }
  std::size_t slots() const { return 1 + 3 * vectors.size() + scalars.size(); }
};

// Our name for a column header or one of its aliases, whatever the case: "Gyro.X" -> "gyr_x",
// "timestamp" -> "t". Empty if it is none.
std::string csv_column_name(std::string_view header);

// Reads the header line `text`, which is line `line` of `file`. InputError if a needed column is
// missing, or two claim the same quantity.
CsvColumns read_csv_header(std::string_view text, const std::string& file, long line,
                           const CsvOptions& options);
// The same of a header that is in its fields already.
CsvColumns read_csv_header(const std::vector<std::string>& headers, char separator,
                           const std::string& file, long line, const CsvOptions& options);

// A file that is only a part of a recording: InputError's own remedy, and whoever has the other
// files may join them (several_files.h).
class MissingSensor : public InputError {
 public:
  using InputError::InputError;
};

// Without the spaces and tabs around it.
std::string_view csv_trimmed(std::string_view text);

}  // namespace magimu
