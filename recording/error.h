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
  InputError(const std::string& file, long line, long column, const std::string& problem,
             const std::string& remedy)
      : std::runtime_error(format(file, line, column, problem, remedy)),
        file(file),
        line(line),
        column(column),
        problem(problem),
        remedy(remedy) {}

  std::string file;
  long line, column;
  std::string problem, remedy;

 private:
  static std::string format(const std::string& file, long line, long column,
                            const std::string& problem, const std::string& remedy) {
    std::string s = file;
    if (line > 0) s += ":" + std::to_string(line);
    if (column > 0) s += ":" + std::to_string(column);
    if (!s.empty()) s += ": ";
    s += problem;
    if (!remedy.empty()) s += "; " + remedy;
    return s;
  }
};

}  // namespace magimu
