// SPDX-License-Identifier: BSD-3-Clause
// Lines that a terminal has put its clock before, whatever they hold:
//
//   12:34:56.789 -> 1,2,3        Arduino IDE
//   [12:34:56.789] 1,2,3         other terminals
//
// Without the clock they are lines like any others; where these have no time, the clock is it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/dialects/head_lines.h"
#include "recording/csv/dialects/line_translator.h"

namespace magimu {

// Takes the clock from the beginning of a line and returns it; nothing, and the line as it was, if
// there is none.
std::optional<std::string_view> take_stamp(std::string_view& line);

// Whether most of the lines have one. If so, it is taken from all lines, and blank lines are
// dropped.
bool take_stamps(std::vector<HeadLine>& lines);

struct StampedLines {
  std::shared_ptr<LineTranslator>
      inner;                // translates lines without their clock; null: these are rows
  bool with_clock = false;  // put the clock before the row
  char separator = ',';     // between clock and row
  std::string header;       // skip lines that, without their clock, equal this
};
std::shared_ptr<LineTranslator> stamped_translator(StampedLines lines);

}  // namespace magimu
