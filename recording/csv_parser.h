// SPDX-License-Identifier: BSD-3-Clause
// Lines of CSV to samples, one line at a time: read_csv feeds it a file, a stream feeds it what
// arrives. The first line that is neither blank nor a comment is the header.
//
//   CsvParser parser("serial port");
//   while (next_line(line)) {
//     parser.line(line);
//     use(parser.take());
//   }
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/csv_columns.h"

namespace magimu {

// Not thread safe. After an InputError the line is lost and the next one may be tried.
class CsvParser {
 public:
  // `file` names the source in messages.
  explicit CsvParser(std::string file, CsvOptions options = {});

  // So many more rows are to come: saves moving their samples about.
  void expect_rows(std::size_t rows) { expected_rows_ = rows; }

  // One line, with or without its line end. InputError names the line, the field and the column.
  void line(std::string_view text);

  // The samples since the last take(); the times must go on increasing all the same. Empty series
  // for the sensors that had none, no magnetometers before the header has come.
  Recording take();

  // take() for readers of whole files: InputError if there was no header, no data, or a needed
  // sensor has no sample. Magnetometers without any are left out, with a note.
  Recording finish();

 private:
  [[noreturn]] void fail(std::size_t field, const std::string& problem,
                         const std::string& remedy) const;
  void header(std::string_view text);
  void row(std::string_view text);
  void check_field_count(std::string_view text) const;
  void put(const CsvColumns::Field& column, double value);
  void number(std::size_t field, std::string_view text);
  void check_time() const;
  void keep_row();
  std::size_t field_of(std::size_t slot) const;
  std::string header_of(std::size_t slot) const;

  std::string file_;
  CsvOptions options_;
  long line_ = 0;  // counts from 1
  bool has_header_ = false;
  std::size_t expected_rows_ = 0;
  CsvColumns columns_;
  Recording recording_;

  std::vector<double> values_;  // the current row, by slot
  std::vector<char> present_;   // by slot: the field was not empty
  bool has_time_ = false;
  double last_time_ = 0.0;
};

}  // namespace magimu
