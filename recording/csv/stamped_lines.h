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

#include "recording/csv/head_lines.h"
#include "recording/csv/line_translator.h"

namespace magimu {

// The clock before a line, which is left without it; nothing where there is none.
std::optional<std::string_view> take_stamp(std::string_view& line);

// Whether most of the lines have one. They are left without it; blank ones are taken out.
bool take_stamps(std::vector<HeadLine>& lines);

struct StampedLines {
  std::shared_ptr<LineTranslator> inner;  // of the lines without clock; null: they are rows
  bool with_clock = false;                // in front of the row
  char separator = ',';                   // behind it
  std::string header;                     // a line without clock that is no row
};
std::shared_ptr<LineTranslator> stamped_translator(StampedLines lines);

}  // namespace magimu
