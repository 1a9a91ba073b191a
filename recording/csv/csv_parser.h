// SPDX-License-Identifier: BSD-3-Clause
// Lines of CSV to samples, one line at a time: read_csv feeds it a file, a stream feeds it what
// arrives. The first line that is neither blank nor a comment is the header.
//
// The times of a stream must increase; they are the column's numbers times the unit given, where a
// rate is given as they stand (or numbers of rows): stream_times.h makes seconds of them. Those of
// a whole file are made of its time column when all of it is there (row_times.h).
//
//   CsvParser parser("serial port");
//   while (next_line(line)) {
//     parser.line(line);
//     use(parser.take());
//   }
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/dialects/csv_dialect.h"
#include "recording/data/error.h"
#include "recording/data/recording.h"
#include "recording/data/times/row_times.h"

namespace magimu {

// A row with fewer fields than the header. If it is the last one, the recording was cut off there.
class ShortRow : public InputError {
 public:
  using InputError::InputError;
};

// Not thread safe. After an InputError the line is lost and the next one may be tried.
class CsvParser {
 public:
  // `file` names the source in messages.
  explicit CsvParser(std::string file, CsvOptions options = {});

  // A whole file of at most `rows` rows follows, and then finish().
  void whole_file(std::size_t rows) {
    whole_file_ = true;
    expected_rows_ = rows;
  }

  // Sets what the first lines say (csv_dialect.h); call it before the first line(). Throws
  // InputError for a header that is not usable.
  void dialect(CsvDialect dialect);

  // One line, with or without its line end. InputError names the line, the field and the column.
  void line(std::string_view text);

  // Returns the samples since the last take(). Times must go on increasing across calls. A sensor
  // without samples has an empty series; before the header there are no magnetometers.
  Recording take();

  // The columns, once the header has been read.
  const CsvColumns& columns() const { return columns_; }

  // The whole recording, at the end of a file. Throws InputError if there was no header, no row, or
  // if a needed sensor has no sample. Magnetometers without samples are left out, with a note.
  Recording finish();

  // Whether any row has been read.
  bool has_rows() const { return has_time_; }

 private:
  [[noreturn]] void fail(std::size_t field, const std::string& problem,
                         const std::string& remedy) const;
  void header(std::string_view text);
  void set_columns(CsvColumns columns, std::string header);
  void row(std::string_view text);
  void check_field_count(std::string_view text) const;
  void put(const CsvColumns::Field& column, double value);
  void number(std::size_t field, std::string_view text);
  bool check_time() const;
  bool whole_sample(std::size_t slot) const;
  void keep_row();
  bool is_of_other_device(std::string_view text);
  bool repeats_last_row();
  std::size_t cycle_of(std::uint32_t sensors);
  std::uint32_t read_again();
  std::uint32_t bit_of_vector(std::size_t i) const;
  std::uint32_t bit_of_scalar(std::size_t i) const;
  bool clock_time(std::size_t field, std::string_view text);
  bool count_each_sensor();
  void set_times(Recording& recording);
  std::size_t field_of(std::size_t slot) const;
  std::string header_of(std::size_t slot) const;

  std::string file_;
  CsvOptions options_;
  CsvDialect dialect_;
  std::shared_ptr<LineTranslator> unquoting_;  // of a plain file's rows with quotation marks
  bool clock_times_ = false;                   // the time column holds times of the day
  long line_ = 0;                              // counts from 1
  bool has_header_ = false, whole_file_ = false;
  std::string header_;
  std::size_t expected_rows_ = 0;
  CsvColumns columns_;
  Recording recording_;

  // What a field holds.
  enum Field : char { kEmpty, kNumber, kNoNumber };  // kNoNumber: nan, null, ...
  std::vector<double> values_;                       // the current row, by slot
  std::vector<Field> present_;                       // by slot
  std::vector<double> taken_off_;                    // by slot: what was added to the reading
  std::optional<double> device_;                     // of the first row, where rows have one
  std::size_t other_devices_ = 0;                    // rows of other devices
  bool has_time_ = false;
  double last_time_ = 0.0;
  std::size_t row_ = 0;    // number of the row, the time of a stream without times
  std::size_t cycle_ = 0;  // number of the cycle, where a line holds one sensor
  std::uint32_t sensors_of_cycle_ = 0;
  std::size_t no_numbers_ = 0, infinite_ = 0;
  long first_no_number_ = 0;

  // Of a whole file. Series hold the number of the row in place of a time until the end.
  RawRows rows_;
  std::vector<double> last_values_;
  std::vector<Field> last_present_;
  std::vector<double> of_one_time_;         // the first readings of the last row's time, by slot
  std::vector<Field> present_at_one_time_;  // whether there are any
  std::size_t repeated_ = 0;
  long first_repeated_ = 0;
};

}  // namespace magimu
