// SPDX-License-Identifier: BSD-3-Clause
// A sensor that walks, rides or flies does not stay within a hand's reach. The hand-held model then
// tilts the trajectory until gravity explains the path: attitudes are off by degrees, and so is the
// distortion. The travelling model (model.h) assumes a bound on the velocity alone.
#pragma once

#include "calibration/fit/held_out.h"
#include "calibration/fit/stage.h"

namespace magimu {

// Is a fit of the hand-held model beyond any hand's reach? It is if the lever arm is longer than
// kLongestArm, or if the reach is at its upper limit kMaxReach and the point that the sensor is
// turned about wanders farther than that allows (chi-square at 0.1 %).
bool is_beyond_reach(const Stage& hand_held);

// Does the model leave a misfit of magnetometer or gyroscope, or ask for a gyroscope that is off by
// more than parts are? Then something else is wrong, which a free motion has only hidden.
bool leaves_a_misfit(const Stage& travelling);

// Correlation of v - R u at two neighbouring weak measurements of the velocity, all recordings
// together, times sqrt(pairs). Where they are independent it is 0 with a standard deviation of 1 if
// the velocity has one axis, and of 0.7 or 0.6 if two or three axes are alike.
struct VelocityCorrelation {
  double sigmas = 0.0;
  int pairs = 0;
};
VelocityCorrelation velocity_correlation(const Stage& travelling);

// Where a hand would have had to hold the sensor, for a sentence: "3.1 m from the point that it was
// turned about".
std::string reach_in_words(const Stage& hand_held);

// A sentence that says why the sensor is taken to have travelled. gain: of the travelling model
// over the hand-held one.
std::string grounds_of_travelling(const Stage& hand_held, const Stage& travelling,
                                  const HeldOutGain& gain);

}  // namespace magimu
