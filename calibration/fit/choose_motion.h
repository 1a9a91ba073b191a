// SPDX-License-Identifier: BSD-3-Clause
// Did the sensor only turn, or did the hand move it? Decided from the data: both models are fitted
// with the magnetometer left out of every other block of seconds and must predict it there; and
// under the rotation model the accelerometer must look like noise about gravity, of the size that
// it has at rest. Where no rest shows that, the fit would take any motion of the hand for noise:
// it must be noise that a part has.
#pragma once

#include <string>
#include <vector>

#include "calibration/fit/stage.h"

namespace magimu {

// The largest density that the accelerometer's noise may have, m/s^2/sqrt(Hz): beyond it, something
// moves.
struct AccNoise {
  double density = 0.0;
  bool at_rest = false;  // measured at rest or given; else that of the noisiest parts
};
// rest_acc: known from rests or given, 0 if unknown.
AccNoise largest_acc_noise(const std::vector<const Recording*>& recordings, double rest_acc);

struct MotionChoice {
  MotionModel motion = MotionModel::kHandHeld;
  std::string reason;  // a sentence with the numbers
};

// Both stages fitted.
MotionChoice choose_motion(const Stage& rotation, const Stage& hand_held, const AccNoise& noise);

}  // namespace magimu
