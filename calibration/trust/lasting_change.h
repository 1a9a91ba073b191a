// SPDX-License-Identifier: BSD-3-Clause
// A magnet that is put on or taken off while the sensor is recorded: what the fit leaves of the
// magnetometer has one mean before and another one after.
#pragma once

#include <optional>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

struct LastingChange {
  double t_s = 0.0;
  double size = 0.0;   // of the step in what is left, in the residuals' unit: at least so much
  double share = 0.0;  // of the squares that it explains
  // Is it a step? It explains more than a drift, and its edge is like no other in the recording.
  bool has_edge = false;
};

// Of residuals at these times, the moment whose two means explain most; nothing where they are few.
std::optional<LastingChange> clearest_change(const std::vector<double>& t,
                                             const std::vector<Vector3>& residuals);

}  // namespace magimu
