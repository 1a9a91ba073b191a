// SPDX-License-Identifier: BSD-3-Clause
// What has changed since a calibration was stored, in words (against.h).
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu {

// "hard_iron" -> "hard iron (magnetometer bias)"
std::string change_title(const std::string& group);
// A group that changed: its size and the usual causes. One that did not: the smallest change that
// would have been seen, and the measured one. Each component with its standard deviation.
std::string change_sentence(const Change& change);

}  // namespace magimu
