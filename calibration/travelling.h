// SPDX-License-Identifier: BSD-3-Clause
// A sensor that walks, drives or flies is not held within a hand's reach, and a model that says so
// tilts the trajectory until gravity explains the way: an attitude that is off by degrees, and a
// distortion with it. What is told of such a motion is its speed alone (model.h, travelling).
#pragma once

#include "calibration/fit/held_out.h"
#include "calibration/fit/stage.h"

namespace magimu {

// Is a fit of the hand-held model out of any hand's reach? The sensor would be farther than an arm
// from the point that it is turned about, or that point wanders farther than an arm can.
bool is_beyond_reach(const Stage& hand_held);

// Would the gyroscope have to be off by more than any part is for this to be true? Then something
// else is wrong, which a free motion has only hidden.
bool asks_too_much_of_gyroscope(const Stage& travelling);

// Correlation of the velocity between two neighbouring measurements of it, all recordings together,
// in its standard deviations: 0 +- 1 where they are independent.
struct VelocityCorrelation {
  double sigmas = 0.0;
  int pairs = 0;
};
VelocityCorrelation velocity_correlation(const Stage& travelling);

// In a sentence: why the sensor is taken to have travelled.
std::string grounds_of_travelling(const Stage& hand_held, const Stage& travelling,
                                  const HeldOutGain& gain);

}  // namespace magimu
