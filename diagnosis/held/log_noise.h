// SPDX-License-Identifier: BSD-3-Clause
// What the size of the noise adds to a negative log-likelihood.
#pragma once

#include <vector>

#include "calibration/fit/stage.h"
#include "graph/linear_system.h"

namespace magimu {

// log det of the noise's root covariance, summed over the sensors' factors (and the hand's reach)
// of each window; window_of: of each node. system: of the stage's graph, or of that and more
// factors.
std::vector<double> log_noise(const Stage& stage, const LinearSystem& system,
                              const std::vector<int>& window_of);

}  // namespace magimu
