// SPDX-License-Identifier: BSD-3-Clause
// Times at which samples arrived, several at once: a sensor with a queue, a bus or a radio hands
// them over in bursts. The sensor measured at its own steady pace; the last sample of a burst is
// about as old as its stamp says.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace magimu {

struct EvenTimes {
  std::vector<double> t;  // one a sample, increasing
  double rate_hz = 0.0;
  double in_a_burst = 0.0;  // samples, on average
  double burst_s = 0.0;     // from burst to burst
};

// t: of one sensor's samples, none earlier than the one before. Nothing where they do not come in
// bursts, or come at no steady pace.
std::optional<EvenTimes> even_times(const std::vector<double>& t);

}  // namespace magimu
