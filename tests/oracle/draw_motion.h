// SPDX-License-Identifier: BSD-3-Clause
// The random curves a motion is made of: turns one after the other, and wandering within a band of
// frequencies. Coefficients whose reach touches a rest are 0, so the rests are exact.
#pragma once

#include "tests/oracle/motion.h"
#include "tests/oracle/random.h"

namespace magimu::oracle {

// The body rate of turns about all axes, both ways; about `axis` alone, to and fro, if it is not
// zero. |omega| hardly exceeds options.fastest_rad_s.
Spline draw_turns(const MotionOptions& options, const Vector3d& axis, Random& random);

// Bounded turning: the curve's farthest point is `farthest` from 0. 0.1 to 0.5 Hz.
Spline draw_bounded_turn(const MotionOptions& options, double farthest, Random& random);

// The heading of what stays level, in z: to and fro by up to a whole turn. 0.01 to 0.08 Hz.
Spline draw_heading(const MotionOptions& options, Random& random);

// The position: root mean square options.displacement_m within options.band_hz while moving, and
// the way out and back of options.carry_m.
Spline draw_displacement(const MotionOptions& options, Random& random);

}  // namespace magimu::oracle
