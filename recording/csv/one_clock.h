// SPDX-License-Identifier: BSD-3-Clause
// Several sources, each with some of the sensors, as one recording: files of a folder, columns with
// times of their own. Their times must come from one clock: what does not overlap is refused.
#pragma once

#include <string>
#include <vector>

#include "recording/csv/csv.h"
#include "recording/data/recording.h"

namespace magimu {

// `parts` have the times of their sources (CsvOptions::keep_origin) and names for messages. Of a
// sensor that several parts have the first is taken, with a note. All magnetometers of one part are
// kept. `path`: for messages. Throws MissingSensor if a sensor is lacking that `options` requires.
Recording joined(std::vector<Recording> parts, const std::string& path, const CsvOptions& options);

// Lets huge times, such as seconds since 1970, count from the first sample, with a note: a double
// holds huge times with too few decimals.
void count_from_first(Recording& recording);

}  // namespace magimu
