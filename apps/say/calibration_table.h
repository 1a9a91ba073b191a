// SPDX-License-Identifier: BSD-3-Clause
// A calibration as people read it: values with their uncertainty and unit, then the verdict.
#pragma once

#include <string>

#include "calibration/result/calibration.h"

namespace magimu::apps {

std::string calibration_table(const Calibration& calibration);

}  // namespace magimu::apps
