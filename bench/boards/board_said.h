// SPDX-License-Identifier: BSD-3-Clause
// What nobody wrote down about a board's numbers, and how an honest sentence would name it.
// Internal to boards.h.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/faults/fault_log.h"

namespace magimu {

struct WrongKind {
  enum Of { kUnit, kTime, kAxis };
  std::string name;
  Of of;
  bool in_counts = false;  // nobody but the data sheet knows how many: a measured factor will do
  const char* sensor;      // regular expression of its names, in lower case
  std::function<void(Log&)> apply;
};

// In an order that never changes: append.
const std::vector<WrongKind>& wrong_kinds();
// Whether the sentence is about this: the sensor, and what is wrong with it.
bool says(const WrongKind& kind, const std::string& sentence);

}  // namespace magimu
