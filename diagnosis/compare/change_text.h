// SPDX-License-Identifier: BSD-3-Clause
// What has changed since a calibration was stored, in words (against.h).
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu {

// "hard_iron" -> "hard iron (magnetometer bias)"
std::string change_title(const std::string& group);
// What changed by how much and what that means; or which change these data exclude, and what they
// show of it. Each component with its standard deviation.
std::string change_sentence(const Change& change);

}  // namespace magimu
