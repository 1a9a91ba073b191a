// SPDX-License-Identifier: BSD-3-Clause
#include "apps/stream/stream_status.h"

#include <cctype>

namespace magimu::apps {
namespace {

// Two or three words for a fault, to be read from two metres.
const char* words_for(const Issue& issue) {
  struct Words {
    const char *kind, *words;
  };
  constexpr Words kWords[] = {{"unit", "Wrong unit"},         {"time_unit", "Wrong time"},
                              {"axes", "Wrong axes"},         {"constant", "Sensor hangs"},
                              {"normalised", "Not raw data"}, {"gravity", "No gravity"},
                              {"absent", "Sensor missing"},   {"not_finite", "Bad numbers"},
                              {"set_aside", "Bad numbers"},   {"time_order", "Wrong time"},
                              {"copied", "Axis missing"},     {"gain_changes", "Gyro changed"}};
  for (const Words& w : kWords) {
    if (issue.kind == w.kind) return w.words;
  }
  return "Stop";
}

}  // namespace

std::string StreamStatus::guidance() const {
  if (const Issue* wrong = fatal()) {
    std::string text = wrong->problem + ". Start again: " + wrong->remedy + ".";
    text.front() = char(std::toupper(static_cast<unsigned char>(text.front())));
    return text;
  }
  return update ? update->guidance : "";
}

std::string StreamStatus::headline() const {
  if (const Issue* wrong = fatal()) return words_for(*wrong);
  return update ? update->headline : "";
}

}  // namespace magimu::apps
