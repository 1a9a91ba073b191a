// SPDX-License-Identifier: BSD-3-Clause
// A calibration that says of itself that it must not be used is not used, unless the user insists.
#pragma once

#include <string>

#include "calibration/result/calibration.h"

namespace magimu::apps {

// False, with the reasons on standard error, where the verdict is "no" and nobody insists.
bool may_be_used(const Calibration& calibration, const std::string& file, bool force);

}  // namespace magimu::apps
