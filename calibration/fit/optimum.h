// SPDX-License-Identifier: BSD-3-Clause
// A fitted stage's graph linearized at its optimum, once for all that is asked of it afterwards:
// residuals, uncertainty, noise.
#pragma once

#include "calibration/fit/stage.h"
#include "calibration/motion/sensor_rows.h"

namespace magimu {

struct Optimum {
  // stage: must outlive this.
  Optimum(const Stage& stage);  // implicit: for those who ask one thing only

  const Stage& stage;
  LinearSystem system;
  SensorRows rows;
};

}  // namespace magimu
