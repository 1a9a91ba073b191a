// SPDX-License-Identifier: BSD-3-Clause
// A calibration as a page to look at and to pass on: verdict, pictures, parameters, checks.
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu::apps {

// recordings: those that were calibrated.
std::string calibration_report(const Calibration& calibration,
                               const std::vector<const Recording*>& recordings);

}  // namespace magimu::apps
