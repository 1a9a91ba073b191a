// SPDX-License-Identifier: BSD-3-Clause
// How a hand moves a board from place to place while it turns it: a smooth random displacement
// within reach, in closed form with its velocity and acceleration, and at rest where the turning
// rests (hand_motion.h). A cubic B-spline with knots about 0.5 s apart, its coefficients correlated
// from one to the next; most of its power lies below 0.7 Hz.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/motions/spline.h"

namespace magimu {

class HandDisplacement {
 public:
  // One spline for each of the motion's stretches. rms_m: root mean square of |p| while the hand
  // moves; negative: drawn from 0.05 to 0.30 m.
  HandDisplacement(std::uint64_t seed, const std::vector<Spline>& stretches, double rms_m);

  // In n: position, m, and its derivatives.
  Vector3 position(double t) const { return at(t, 0); }
  Vector3 velocity(double t) const { return at(t, 1); }
  Vector3 acceleration(double t) const { return at(t, 2); }

 private:
  Vector3 at(double t, int derivative) const;
  std::vector<Spline> splines_;
};

}  // namespace magimu
