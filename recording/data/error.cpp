// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/error.h"

namespace magimu {
namespace {

std::string format(const std::string& in_file, long at_line, long at_column,
                   const std::string& what_is_wrong, const std::string& what_to_do) {
  std::string s = in_file;
  if (at_line > 0) s.append(":").append(std::to_string(at_line));
  if (at_column > 0) s.append(":").append(std::to_string(at_column));
  if (!s.empty()) s += ": ";
  s += what_is_wrong;
  if (!what_to_do.empty()) s.append("; ").append(what_to_do);
  return s;
}

}  // namespace

InputError::InputError(const std::string& in_file, long at_line, long at_column,
                       const std::string& what_is_wrong, const std::string& what_to_do)
    : std::runtime_error(format(in_file, at_line, at_column, what_is_wrong, what_to_do)),
      file(in_file),
      line(at_line),
      column(at_column),
      problem(what_is_wrong),
      remedy(what_to_do) {}

}  // namespace magimu
