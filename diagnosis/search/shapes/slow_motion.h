// SPDX-License-Identifier: BSD-3-Clause
// The residuals of a sensor under a fitted model, node by node, while the sensor is turned and
// while it is at rest. Have they more power in the band of a hand's motion than noise has?
#pragma once

#include <cmath>
#include <vector>

#include "calibration/fit/stage.h"
#include "calibration/motion/sensor_rows.h"

namespace magimu {

// Whitened, turned into the navigation frame, each piece without a gap.
struct NodeResiduals {
  std::vector<std::vector<Vector3>> moving, still;  // of each rest one
  double interval_s = 0.0;                          // between nodes
};
NodeResiduals node_residuals(const Stage& stage, const std::vector<const Recording*>& recordings,
                             Sensor sensor);

// Power from 0.5 to 1, 1.25 or 1.5 Hz over that beyond 2.5 Hz, which a hand hardly reaches. It is
// weighted by the fourth power of the frequency, since a hand moves about as far at each frequency
// of its band. Of the three bands the one with the largest z is taken. White noise has the same
// power in all bands. Coloured noise has not, but it has no more in motion than at rest, and no
// more than below 0.3 Hz, where a hand, which stays within its reach, hardly accelerates. Values
// are clipped at three standard deviations: blows are not slow. All zero without a rest of eight
// nodes, or where nodes are too slow for these bands.
inline constexpr int kHandsBands = 3;
struct SlowPower {
  double log_ratio = 0.0, sigma = 0.0;  // beyond the ratio at rest, where that is more than white
  double squares = 0.0;                 // in the band beyond noise, whitened
  double unknowns = 0.0;                // coefficients in the band
  // Logarithm of the power in the band over that at rest, and over that from 0.05 to 0.3 Hz while
  // moving, in standard deviations.
  double over_rest = 0.0, over_slower = 0.0;

  double over_coloured() const { return (over_rest + over_slower) / std::sqrt(2.0); }
  double z() const { return sigma > 0.0 ? log_ratio / sigma : 0.0; }
};
enum class Axes { kAll, kVertical };
SlowPower slow_power(const NodeResiduals& residuals, Axes axes = Axes::kAll);

}  // namespace magimu
