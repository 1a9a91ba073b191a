// SPDX-License-Identifier: BSD-3-Clause
#include "factors/effects/bandwidth.h"

#include <fmt/format.h>

#include <cmath>

namespace magimu {

std::string bandwidth_sentence(const std::string& sensor, double v, double sigma) {
  const double spread = std::sqrt(std::abs(v)), of_spread = 0.5 * sigma / std::max(spread, 1e-12);
  if (v < 0.0) {
    return fmt::format(
        "The {} sharpens what bends, beside its delay: its filter overshoots, and the ages of what "
        "it shows have a variance of -({:.1f} +- {:.1f} ms)^2.",
        sensor, 1e3 * spread, 1e3 * of_spread);
  }
  return fmt::format(
      "The {} averages over some time, beside its delay: the ages of what it shows spread by "
      "{:.1f} +- {:.1f} ms (a standard deviation; a mean over {:.0f} ms does so).",
      sensor, 1e3 * spread, 1e3 * of_spread, 1e3 * std::sqrt(12.0) * spread);
}

}  // namespace magimu
