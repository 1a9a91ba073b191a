// SPDX-License-Identifier: BSD-3-Clause
// A calibration as a file of the format "magimu-calibration/1" (docs/formats.md lists its fields).
#pragma once

#include <nlohmann/json.hpp>

#include "calibration/calibration.h"

namespace magimu {

nlohmann::ordered_json to_json(const Calibration& calibration);

}  // namespace magimu
