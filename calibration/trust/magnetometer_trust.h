// SPDX-License-Identifier: BSD-3-Clause
// May one magnetometer of an array be believed? Each is judged by its own residuals, its own
// parameters and its own samples, so that one that is out of order does not spoil the others: in
// the fit it counts by its own noise density, which grows to what it leaves.
#pragma once

#include "calibration/result/calibration.h"

namespace magimu {

// Fills the trust of each record, and lowers the device's where one of them is not `yes`: to
// `limited` with their names, to `no` where none is left. Nothing of a single magnetometer. After
// the checks are made.
void judge_magnetometers(Calibration& c);

}  // namespace magimu
