// SPDX-License-Identifier: BSD-3-Clause
// A recording as the stream that it was.
#pragma once

#include "calibration/live/stream_estimate.h"
#include "calibration/live/streaming.h"
#include "recording/read.h"
#include "sim/simulate.h"

namespace magimu {

// paper, hand_held; else hand.
inline SimulatedMotion motion_named(const std::string& name) {
  return name == "paper"       ? SimulatedMotion::kPaper
         : name == "hand_held" ? SimulatedMotion::kHandHeld
                               : SimulatedMotion::kHand;
}

// All samples of one time as one, in the order of time.
inline std::vector<StreamSample> samples_of(const Recording& r) {
  std::vector<StreamSample> out;
  std::vector<std::size_t> next(2 + r.mag.size(), 0);
  const auto series = [&](std::size_t i) -> const VectorSeries& {
    return i == 0 ? r.acc : i == 1 ? r.gyr : r.mag[i - 2];
  };
  for (;;) {
    double t = 1e300;
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (next[i] < series(i).size()) t = std::min(t, series(i).t[next[i]]);
    }
    if (t == 1e300) return out;
    StreamSample s;
    s.t = t;
    s.mag.resize(r.mag.size());
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (next[i] >= series(i).size() || series(i).t[next[i]] > t) continue;
      std::optional<Vector3>& to = i == 0 ? s.acc : i == 1 ? s.gyr : s.mag[i - 2];
      to = series(i).v[next[i]++];
    }
    out.push_back(s);
  }
}

}  // namespace magimu
