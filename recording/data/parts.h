// SPDX-License-Identifier: BSD-3-Clause
// Parts of a recording: what lies between long gaps of its gyroscope or accelerometer, where nobody
// knows how the sensor moved. Each is a Recording of its own, with an attitude of its own at its
// beginning; device and field are those of the whole (Recording::continues_previous).
//
// How long a gap may be bridged follows from the motion itself: while samples are missing the rate
// before the gap is held. Where the turn so found is less certain than what a fresh start knows of
// its attitude, the parts are better taken apart.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

constexpr double kLongestBridge = 1.0;  // s: at rest, too, a hand may begin and end a turn in it

// Seconds without a sample that may be bridged in this recording, at the most kLongestBridge (but
// four usual intervals of a slow sensor).
double longest_bridge(const Recording& recording);

// The parts in the order of time, all but the first with continues_previous; nothing where the
// recording is in one piece. Parts too short to tell anything are left out, and `warnings` says so;
// that may be all of them.
std::optional<std::vector<Recording>> parts_of(const Recording& recording,
                                               std::vector<std::string>& warnings);

// Long enough, and with enough samples of every sensor, to tell something by itself.
bool tells_something(const Recording& part);

}  // namespace magimu
