// SPDX-License-Identifier: BSD-3-Clause
// The calibration of recordings that permit no fit: verdict `no`, the reason, and parameters that
// claim nothing (axes as they are, no bias, standard deviations as large as the readings), so that
// the file can be written and read like any other.
#pragma once

#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"
#include "recording/data/error.h"

namespace magimu {

// why: what failed, the message of a NumericalError. warnings: what the checks found in the
// recordings; they are likely to be behind the failure and join the reasons.
Calibration calibration_without_fit(const std::vector<const Recording*>& recordings,
                                    const CalibrationOptions& options, const std::string& why,
                                    const std::vector<std::string>& warnings);
Calibration calibration_without_fit(const std::vector<const Recording*>& recordings,
                                    const CalibrationOptions& options, const TooLittle& too_little);

}  // namespace magimu
