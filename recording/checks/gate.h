// SPDX-License-Identifier: BSD-3-Clause
// The gate in front of everything that looks at a recording: samples that no measurement can have
// given are set aside, each for its sensor alone, before a check of units, a search for rests or a
// fit sees them. sensor_gate.h has the rules; streams use it sample by sample.
//
// What a sample leaves is a gap of its sensor; short holes of a gyroscope are bridged (bridge.h).
#pragma once

#include <optional>

#include "recording/data/recording.h"

namespace magimu {

struct GateOptions {
  // Clipped readings of magnetometers stay: for whoever wants to know that they are clipped.
  bool keep_clipped_mag = false;
};

// The recording without them, and with its set_aside filled; nothing where all may stay, or where
// the recording has been here before. A sensor of which next to nothing would be left stays as it
// is, and set_aside says so: check_recording() refuses the recording.
std::optional<Recording> gated(const Recording& recording, const GateOptions& options = {});

// Throws an InputError where most samples of a sensor are set aside: what is left is no recording
// of it, for whatever purpose.
void refuse_mostly_set_aside(const Recording& recording);

}  // namespace magimu
