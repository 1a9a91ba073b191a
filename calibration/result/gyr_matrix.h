// SPDX-License-Identifier: BSD-3-Clause
// The gyroscope's matrix where it is part of a calibration.
#pragma once

#include "calibration/result/calibration.h"

namespace magimu {

// What the rates are multiplied by: I, or I + S where S is part of the model.
Matrix3 gyr_matrix(const Calibration& c);

}  // namespace magimu
