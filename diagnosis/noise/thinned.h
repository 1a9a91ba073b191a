// SPDX-License-Identifier: BSD-3-Clause
// Fast recordings at a rate that carries a hand's motion with something to spare: means of
// neighbouring samples, so that no information about slow things is lost and fits take a fraction
// of the time. The noise is tested on the samples as they are.
#pragma once

#include "recording/data/recording.h"

namespace magimu {

// Each sensor that is faster than 150 Hz at 75 to 150 Hz. An accelerometer's or magnetometer's mean
// is at the mean of its samples' times, a gyroscope's at the first, as the interval that it spans.
Recording thinned(const Recording& recording);
bool is_thinned(const VectorSeries& series);

// Without all but a few seconds of the rests at its ends: where a sensor lies on a table, the field
// is another than where it is turned in the hand. What was cut goes to notes.
Recording without_long_rests(const Recording& recording, std::vector<std::string>& notes);

}  // namespace magimu
