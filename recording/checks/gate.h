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
  // Keep clipped readings of magnetometers: the diagnosis looks for them. Default false.
  bool keep_clipped_mag = false;
};

// A copy of the recording without those samples, with set_aside filled. Nothing if all samples may
// stay, or if the recording is such a copy already. A sensor that would lose nearly all samples
// keeps them, set_aside says so, and check_recording() then refuses the recording.
std::optional<Recording> gated(const Recording& recording, const GateOptions& options = {});

// Throws InputError if most samples of a sensor were set aside that cannot be left out
// (dead_magnetometers.h).
void refuse_mostly_set_aside(const Recording& recording);

}  // namespace magimu
