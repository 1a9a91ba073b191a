// SPDX-License-Identifier: BSD-3-Clause
// A magnet that is put on or taken off while the sensor is recorded: what the fit leaves of the
// magnetometer has one mean before and another one after, which explains more of it than a drift
// does, and an edge between them beyond what readings whose neighbours are alike have.
#pragma once

#include <optional>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

struct LastingChange {
  double t_s = 0.0;
  double size = 0.0;  // of the step in what is left, in the residuals' unit: at least so much
};

// Of residuals at these times; nothing where none shows.
std::optional<LastingChange> lasting_change(const std::vector<double>& t,
                                            const std::vector<Vector3>& residuals);

}  // namespace magimu
