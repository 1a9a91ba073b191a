// SPDX-License-Identifier: BSD-3-Clause
// One of several recordings of the same device: motion, dip and noise are those of a simulation,
// the device's parameters are given.
#pragma once

#include "sim/simulate.h"

namespace magimu {

// options.seed draws motion, dip and noise; parameters.dip_rad does not count. No hidden effects.
Simulation simulate_device(const SimulationOptions& options, const SensorParameters& parameters);

}  // namespace magimu
