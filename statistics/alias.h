// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace magimu {

// Where a line appears in samples, Hz: folded into 0 .. half the rate.
inline double alias(double line_hz, double rate_hz) {
  return std::abs(line_hz - rate_hz * std::round(line_hz / rate_hz));
}

}  // namespace magimu
