// SPDX-License-Identifier: BSD-3-Clause
// What a long stream costs: memory, a restart, and the end against a fit of all samples at once.
// Each part runs in a process of its own, so that only its own memory counts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "calibration/live/streaming.h"
#include "sim/simulate.h"

namespace magimu {

// batch: the fit of all samples too (three hours at 200 Hz need several GB). Files go to `folder`,
// which is to be there, and stay: samples, estimate, results.
void measure_memory(const SimulationOptions& simulation, const StreamingOptions& options,
                    const std::string& folder, bool batch);

// How long updates took: (time in the stream, s; processor time, us) of each.
void print_latency(const std::vector<std::pair<double, double>>& updates);

}  // namespace magimu
