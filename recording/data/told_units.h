// SPDX-License-Identifier: BSD-3-Clause
// Units that the user gave by an option, beside those that a file's own header gives. A header may
// be wrong: readings that contradict it are refused. The user is asked once, and then believed.
// Recording::file_units carries both, the user's in an entry of its own.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

namespace magimu {

inline std::string told_unit_key(const std::string& quantity) { return "told " + quantity; }

// One of the user's units in ours; empty: none was given.
inline void tell_units(std::map<std::string, double>& file_units, std::optional<double> acc,
                       std::optional<double> gyr, std::optional<double> mag) {
  for (const auto& [quantity, unit] : {std::pair("acc", acc), {"gyr", gyr}, {"mag", mag}}) {
    if (unit) file_units[quantity] = file_units[told_unit_key(quantity)] = *unit;
  }
}

inline bool unit_was_told(const std::map<std::string, double>& file_units,
                          const std::string& quantity) {
  return file_units.contains(told_unit_key(quantity));
}

}  // namespace magimu
