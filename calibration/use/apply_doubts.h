// SPDX-License-Identifier: BSD-3-Clause
// Whether a recording that was corrected can be one of the device that the calibration is of.
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu {

// Sentences for people: a field of another length than the calibration's, or of many. InputError
// where no two places on Earth differ so much: the readings have another unit.
std::vector<std::string> doubts_of_field(const Calibration& calibration,
                                         const Recording& corrected);

}  // namespace magimu
