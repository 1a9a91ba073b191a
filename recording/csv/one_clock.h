// SPDX-License-Identifier: BSD-3-Clause
// Several sources, each with some of the sensors, as one recording: files of a folder, columns with
// times of their own. Their times must come from one clock: what does not overlap is refused.
#pragma once

#include <string>
#include <vector>

#include "recording/csv/csv.h"
#include "recording/data/recording.h"

namespace magimu {

// A part's times are those of its source (CsvOptions::keep_origin); its name is for messages.
// Of a sensor that several parts have, the first is taken, and `notes` tells. All magnetometers are
// kept if they come from one part. path: of the whole, for messages. MissingSensor if together they
// lack what `options` requires.
Recording joined(std::vector<Recording> parts, const std::string& path, const CsvOptions& options);

// Seconds since 1970 are so large that a double holds them less exactly than times are told apart:
// huge times count from the first sample instead, and a note says so.
void count_from_first(Recording& recording);

}  // namespace magimu
