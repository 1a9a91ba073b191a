// SPDX-License-Identifier: BSD-3-Clause
// Magnetometers of an array that do not measure: a wire is broken, the bus hangs, an axis is
// written twice. The others are worth as much without them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

struct DeadMagnetometer {
  std::string name;
  std::string problem, remedy;  // sentences without a full stop, as in quality.h
};

// "mag2 is left out: it reads (0, 0, 0) uT in all 12000 samples".
std::string left_out_sentence(const std::string& name, const std::string& problem);

// Those of a recording: most of their readings are no measurements (gate.h), or one of their axes
// is none. Empty where no other would be left.
std::vector<DeadMagnetometer> dead_magnetometers(const Recording& recording);

// Recordings of one device without the magnetometers that are dead in any of them, which their
// cautions tell. As they are where none would be left.
void leave_out_dead_magnetometers(std::span<Recording> recordings);

}  // namespace magimu
