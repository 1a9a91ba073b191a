// SPDX-License-Identifier: BSD-3-Clause
// Recordings as the search for causes uses them: at a lower rate, so that its hundreds of fits take
// a fraction of the time. The noise is tested on the samples as they are.
#pragma once

#include "recording/data/recording.h"

namespace magimu {

// Each sensor that is faster than 150 Hz at 75 to 150 Hz (calibration/motion/slower_recordings.h).
Recording thinned(const Recording& recording);
bool is_thinned(const VectorSeries& series);

// Without all but a few seconds of the rests at its ends: where a sensor lies on a table, the field
// is another than where it is turned in the hand. What was cut goes to notes.
Recording without_long_rests(const Recording& recording, std::vector<std::string>& notes);

}  // namespace magimu
