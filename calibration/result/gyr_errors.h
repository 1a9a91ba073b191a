// SPDX-License-Identifier: BSD-3-Clause
// The gyroscope's scale errors and misalignment where they are part of a calibration.
#pragma once

#include "calibration/result/calibration.h"

namespace magimu {

// S of gyr = (I + S) omega + o_w; zero where the model has none.
Matrix3 gyr_errors(const Calibration& c);

}  // namespace magimu
