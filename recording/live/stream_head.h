// SPDX-License-Identifier: BSD-3-Clause
// What kind of text a stream is, told from its first lines as they come, by the code that tells it
// of a file (csv/dialects/csv_dialect.h): what a board prints when it starts, a terminal's time
// stamps, labelled numbers, other separators, a decimal comma. A header in the plainest dialect is
// known with the first row below it; all else once kLinesToTell lines are there. Afterwards no line
// waits.
//
//   StreamHead head("serial:/dev/ttyUSB0", options);
//   if (head.push(line, number, false)) read(head.parser(), head.take_rows());
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/csv_parser.h"

namespace magimu {

class StreamHead {
 public:
  // Lines after which the dialect is asked for, and again after as many more: enough that each
  // sensor of a usual stream has come.
  static constexpr std::size_t kLinesToTell = 25;
  // Lines that are kept: what a board prints at its start is shorter.
  static constexpr std::size_t kMostLines = 200;

  struct Line {
    std::string text;
    long number = 0;    // in the stream
    bool half = false;  // perhaps only the end of one
  };

  // options.header: that of a stream that sends none.
  StreamHead(std::string source, const CsvOptions& options);

  // One line more, blank ones included; whether the dialect is known by now.
  bool push(Line line);
  // Nothing more will come: what the lines so far tell.
  bool finish() { return recognise(); }

  // Once it is known: a parser that knows its columns and has read no row; the header line, which
  // may come again; whether that is a header of the plainest dialect; the lines below it.
  const CsvParser& parser() const { return *parser_; }
  const std::string& header() const { return header_; }
  bool plain() const { return plain_; }
  std::vector<Line> take_rows();

  // Until then: why not, as far as anybody has looked.
  const std::optional<InputError>& failure() const { return failure_; }
  // Whether there are as many lines as are kept: with one more the first half is forgotten.
  bool full() const;

 private:
  bool plain_row(const std::string& row);
  void plain_header(const std::string& text);
  bool recognise();
  void use(const CsvDialect& dialect);
  InputError in_the_stream(const InputError& error) const;

  std::string source_;
  CsvOptions options_;
  std::vector<Line> lines_;
  std::size_t bytes_ = 0, with_content_ = 0;
  std::optional<CsvParser> above_;  // of the last plain header
  std::string above_text_;
  std::optional<CsvParser> parser_;
  std::string header_;
  bool plain_ = false;
  std::size_t first_row_ = 0;  // of lines_
  std::optional<InputError> failure_;
};

}  // namespace magimu
