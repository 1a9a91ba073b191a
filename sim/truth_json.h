// SPDX-License-Identifier: BSD-3-Clause
// The truth behind a simulated recording as JSON, for `magimu simulate --truth`: the parameters
// under the names of a calibration file, so that the two compare field by field, and what made the
// data: seed, rate_hz, mag_ratio, motion, gravity and the noise densities in the measurements. The
// trajectory is left out.
#pragma once

#include <nlohmann/json.hpp>

#include "sim/simulate.h"

namespace magimu {

nlohmann::json to_json(const SimulationTruth& truth, const SimulationOptions& options);

}  // namespace magimu
