// SPDX-License-Identifier: BSD-3-Clause
// What a calibration leaves of a magnetometer: measured less predicted at its nodes, and the same
// readings corrected.
#pragma once

#include <vector>

#include "calibration/calibration.h"
#include "diagnosis/diagnosis.h"
#include "recording/recording.h"

namespace magimu::apps {

// Whitened (1: one standard deviation of the noise of the samples averaged for a node), of all
// recordings, one after the other. recordings: as they were calibrated.
ResidualTrace field_residuals(const Calibration& calibration,
                              const std::vector<const Recording*>& recordings,
                              std::size_t magnetometer);

}  // namespace magimu::apps
