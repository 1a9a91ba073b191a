// SPDX-License-Identifier: BSD-3-Clause
// calibrate() of all samples, also where the magnetometer's bias changed among them: for whoever
// looks for the change himself. (calibrate() then gives what holds since then.)
#pragma once

#include "calibration/calibrate.h"

namespace magimu {

Calibration calibrate_whole(const std::vector<const Recording*>& recordings,
                            const CalibrationOptions& options = {});

}  // namespace magimu
