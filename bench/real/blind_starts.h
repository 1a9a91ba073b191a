// SPDX-License-Identifier: BSD-3-Clause
// Does the optimization reach the same minimum from anywhere? Starts with every attitude 30 deg off
// the vertical and 60 deg in heading, D 20 % and o_m 5 uT off, signs and directions random, against
// the ordinary start.
#pragma once

#include "calibration/calibrate.h"

namespace magimu {

struct BlindStarts {
  int starts = 0;
  // One model, its noise given (the reach of the hand still follows from the data).
  int same = 0;        // converged to the ordinary start's minimum
  int trusted = 0;     // ended elsewhere with cos(alpha) > 0 and another verdict than "no"
  int wrong_sign = 0;  // ended with cos(alpha) <= 0
  double worst = 0.0;  // largest distance of a parameter among the same, model sigmas
  // Everything as users have it: model of the motion, lag and noise found from that start as well.
  int whole_same = 0;        // the same choices, parameters within kWholeSame
  double whole_worst = 0.0;  // largest distance among all, reported sigmas

  // Where the noise is estimated until it changes by less than a per cent, a run's last digits
  // depend on its start.
  static constexpr double kWholeSame = 0.1;  // reported sigmas
};

// Equal minima: parameters within 0.01 of the model's sigmas, or the cost within 1e-6 of it.
// whole: run everything as users have it, too.
BlindStarts blind_starts(const Recording& recording, const Calibration& ordinary, int starts,
                         bool whole);

}  // namespace magimu
