// SPDX-License-Identifier: BSD-3-Clause
// A recording once more, as a model would have measured it: the motion, device and densities that
// the model finds in it, new noise (`magimu simulate --like REC.csv --model DIAG.json`).
#pragma once

#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "recording/data/recording.h"
#include "sim/simulate.h"

namespace magimu::apps {

// What simulate() needs for it; seed and noise factor are left as they are. model: a diagnosis file
// ("": the basic model), of which the model at its end is taken: motion, causes, noise. notes:
// causes that a simulation does not know. Throws InputError where the model cannot be fitted.
void make_replica(const Recording& recording, const std::string& model, SimulationOptions& options,
                  std::vector<std::string>& notes);

}  // namespace magimu::apps
