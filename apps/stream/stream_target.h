// SPDX-License-Identifier: BSD-3-Clause
// When a stream's estimate is good enough, as the user writes it ("heading=0.5deg,mag_bias=0.2uT"),
// and how far it has come.
#pragma once

#include <string>
#include <vector>

#include "calibration/live/streaming.h"

namespace magimu::apps {

// Names: heading (deg), mag_bias (uT), acc_bias (m/s^2), gyr_bias (rad/s; deg/s). InputError names
// what is not understood.
StreamTarget parse_stream_target(const std::string& text);

// One standard deviation and its limit, in the unit that is shown.
struct TargetProgress {
  std::string label, unit;
  double sigma = 0.0;  // not a number: not known yet
  double limit = 0.0;

  bool met() const { return sigma <= limit; }
};
// Every limit that is given; the default one where none is.
std::vector<TargetProgress> target_progress(const StreamTarget& target, const StreamUpdate& update);

}  // namespace magimu::apps
