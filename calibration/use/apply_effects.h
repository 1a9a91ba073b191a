// SPDX-License-Identifier: BSD-3-Clause
// The readings of a recording without biases, distortion and the effects of a calibration: each
// effect is defined once (factors/effects), as what it adds to a reading, and is solved for here by
// iteration. For apply.cpp; others want apply.h.
#pragma once

#include "calibration/use/apply.h"

namespace magimu {

// An active effect's parameters in the order of its definition in factors/effects, 0 where the
// calibration holds them at 0. InputError if there is no effect of that name.
VectorXd effect_theta(const ActiveEffect& effect);

// Corrects out.recording in place; adds to its formulas and to what was not applied.
void correct_readings(const Calibration& calibration, Applied& out);

}  // namespace magimu
