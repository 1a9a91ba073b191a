// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/blows.h"

namespace magimu {

double blows_per_minute(const Recording& recording) {
  constexpr double kBlow = 20.0;     // m/s^2, second difference
  constexpr double kTogether = 0.1;  // s
  const VectorSeries& acc = recording.acc;
  int blows = 0;
  double last = -1e30;
  for (std::size_t k = 1; k + 1 < acc.size(); ++k) {
    if ((acc.v[k - 1] - 2.0 * acc.v[k] + acc.v[k + 1]).norm() < kBlow) continue;
    if (acc.t[k] > last + kTogether) ++blows;
    last = acc.t[k];
  }
  const double minutes = recording.duration_s() / 60.0;
  return minutes > 0.0 ? blows / minutes : 0.0;
}

}  // namespace magimu
