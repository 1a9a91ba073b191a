// SPDX-License-Identifier: BSD-3-Clause
// Times that were rounded to a step as long as the sampling interval, or nearly: 104 samples a
// second with two decimals of a second. Stamps that a steady clock and rounding explain tell that
// clock far better than each stamp does: its rate to a step over the whole recording, its phase to
// a small part of a step.
#pragma once

#include <optional>
#include <vector>

namespace magimu {

struct RoundedTimes {
  double step_s = 0.0;    // all times are whole numbers of it apart
  double rate_hz = 0.0;   // of the samples, on average
  double within_s = 0.0;  // of the times given: half a step, or a whole one where samples came a
                          // little unevenly, too
  std::vector<double> t;  // even ones, so near to those given; empty: the samples do not come
                          // evenly, or were lost now and then
};

// t: of one sensor's samples, none earlier than the one before. Nothing where the step is short
// beside the sampling interval, or the times are even as they are.
std::optional<RoundedTimes> rounded_times(const std::vector<double>& t);

}  // namespace magimu
