// SPDX-License-Identifier: BSD-3-Clause
// Refuses a calibration whose own verdict is "no", unless the user insists (--force).
#pragma once

#include <string>

#include "calibration/result/calibration.h"

namespace magimu::apps {

// False if the verdict is "no" and `force` is not given. The reasons of a "no" go to standard error
// in either case.
bool may_be_used(const Calibration& calibration, const std::string& file, bool force);

}  // namespace magimu::apps
