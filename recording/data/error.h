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
             const std::string& what_is_wrong, const std::string& what_to_do);

  std::string file;
  long line, column;
  std::string problem, remedy;
};

// The recording can be read, but there is too little in it for what is asked.
class TooLittle : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace magimu
