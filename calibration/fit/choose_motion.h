// SPDX-License-Identifier: BSD-3-Clause
// Did the sensor only turn, or did the hand move it? Decided from the data: both models are fitted
// with the magnetometer left out of every other block of seconds and must predict it there; and
// under the rotation model the accelerometer must look like noise about gravity.
#pragma once

#include <string>

#include "calibration/fit/stage.h"

namespace magimu {

struct MotionChoice {
  MotionModel motion = MotionModel::kHandHeld;
  std::string reason;  // a sentence with the numbers
};

// Both stages fitted. rest_acc: accelerometer density known from rests or given, 0 if unknown.
MotionChoice choose_motion(const Stage& rotation, const Stage& hand_held, double rest_acc);

}  // namespace magimu
