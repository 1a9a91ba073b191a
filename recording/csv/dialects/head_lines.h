// SPDX-License-Identifier: BSD-3-Clause
// The first lines of a text that may be a table: which separator it has, which lines are its rows.
// Internal to csv_dialect.cpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace magimu {

struct HeadLine {
  std::string_view text;  // without line end and the blanks around it
  long number = 0;        // in the file, from 1
};

// The lines of a text that are not blank.
std::vector<HeadLine> head_lines(std::string_view head);

// "# t,acc_x" and "// t,acc_x" -> "t,acc_x"
std::string_view without_comment_mark(std::string_view text);
bool is_comment(std::string_view text);

struct TableShape {
  char separator = ',';
  bool decimal_comma = false;
  char group_mark = 0;      // between groups of three digits, 0: none
  bool quoted = false;      // numbers in quotation marks
  bool empty_last = false;  // every row ends with a separator
  bool single_blanks =
      true;  // with separator ' ': rows have single blanks only, no tabs, none at the end
  std::size_t fields = 0;     // of most rows; 0: there are no rows
  std::size_t first_row = 0;  // index in the lines
};

TableShape table_shape(const std::vector<HeadLine>& lines);

}  // namespace magimu
