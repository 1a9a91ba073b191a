// SPDX-License-Identifier: BSD-3-Clause
// A recording of rows becomes one of times, when all rows of a file are there. Internal to
// recording/csv.
#pragma once

#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// Replaces the number of the row, which stands in place of every sample's time, by the row's time
// in s. Samples come in the order of time; those of a row without a time (NaN) are left out, and so
// are all but the first of a sensor's samples at one time.
void give_times(Recording& recording, const std::vector<double>& times);

// Magnetometers whose readings were taken for uT, but can only be in tesla, as ROS writes them: no
// magnetometer on Earth reads less than a nanotesla in every attitude. Converts them, with a note.
void recognise_tesla(Recording& recording);

}  // namespace magimu
