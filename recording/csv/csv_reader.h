// SPDX-License-Identifier: BSD-3-Clause
// A text that comes in pieces to a recording: its first pieces tell the dialect, the rest goes line
// by line through CsvParser.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/csv_parser.h"
#include "recording/csv/dialects/csv_dialect.h"
#include "recording/data/error.h"

namespace magimu {

class CsvReader {
 public:
  // `path`, for messages, must outlive the reader.
  CsvReader(const std::string& path, const CsvOptions& options) : path_(path), options_(options) {}

  // Whole lines from all over the text, to be given before the first piece: they show sensors that
  // the head does not have.
  void elsewhere(std::string lines) { elsewhere_ = std::move(lines); }
  // `size`: bytes of the whole text; 0 if unknown.
  void push(std::string_view piece, std::size_t size);
  Recording finish();

 private:
  void begin(bool whole);
  void lines(std::string_view piece);
  void whole_lines(std::string_view piece);
  void line(std::string_view text);
  void set_aside(const InputError& error);
  void last_line_failed();
  void tell_set_aside(Recording& recording) const;
  void refuse_long_line();
  std::size_t expected_rows() const;

  const std::string& path_;
  const CsvOptions& options_;
  std::string elsewhere_;
  std::string head_;  // until the dialect is known
  bool has_begun_ = false;
  bool returns_ = false;  // lines end with a carriage return alone (old spreadsheets)
  std::size_t size_ = 0;
  CsvDialect dialect_;
  std::vector<CsvParser> parsers_;  // one; or one for each sensor that has a time column
  std::string begun_;               // a line whose end has not come yet
  long lines_ = 0;                  // that have ended
  // The error of the line before, if it could not be read. If no line follows, it was cut off.
  std::optional<InputError> failed_;
  std::optional<InputError> first_broken_;  // the first error in a line that is not the last one
  std::size_t broken_ = 0, expected_rows_ = 0;
  bool failed_short_ = false, at_end_ = false;
  long cut_off_ = 0;
};

}  // namespace magimu
