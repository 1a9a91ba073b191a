// SPDX-License-Identifier: BSD-3-Clause
// Does an accelerometer read gravity, or has somebody taken it off ("user acceleration", "linear
// acceleration")? No unit tells: a hand accelerates as much as a g by itself. Turned by the
// gyroscope into one frame, gravity is the mean of every stretch of time; what is left without it
// averages to a change of velocity over that time, to nearly nothing.
#pragma once

#include "recording/data/recording.h"

namespace magimu {

// Whether it does not read gravity. False where nothing tells: no magnetometer that confirms the
// gyroscope's unit, too little motion.
bool lacks_gravity(const Recording& recording);

}  // namespace magimu
