// SPDX-License-Identifier: BSD-3-Clause
// The exception for input that cannot be read or used: what is wrong, where, and the remedy.
#pragma once

#include <stdexcept>
#include <string>

namespace magimu {

// what(): "FILE:LINE:COLUMN: problem; remedy", the parts that are known.
class InputError : public std::runtime_error {
 public:
  // line and column count from 1; 0: not known.
  InputError(const std::string& in_file, long at_line, long at_column,
             const std::string& what_is_wrong, const std::string& what_to_do)
      : std::runtime_error(format(in_file, at_line, at_column, what_is_wrong, what_to_do)),
        file(in_file),
        line(at_line),
        column(at_column),
        problem(what_is_wrong),
        remedy(what_to_do) {}

  std::string file;
  long line, column;
  std::string problem, remedy;

 private:
  static std::string format(const std::string& in_file, long at_line, long at_column,
                            const std::string& what_is_wrong, const std::string& what_to_do) {
    std::string s = in_file;
    if (at_line > 0) s += ":" + std::to_string(at_line);
    if (at_column > 0) s += ":" + std::to_string(at_column);
    if (!s.empty()) s += ": ";
    s += what_is_wrong;
    if (!what_to_do.empty()) s += "; " + what_to_do;
    return s;
  }
};

}  // namespace magimu
