// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/usual_readings.h"

#include <algorithm>

namespace magimu {

void UsualReadings::look_up(const SensorHabits& habits, double largest_at_least) {
  settled = habits.settled();
  length = habits.usual_length();
  largest = std::max(habits.largest_length(), largest_at_least);
  repeats = habits.repeats();
  same_noise = habits.same_noise();
  lively = habits.lively(0) || habits.lively(1) || habits.lively(2);
  for (int axis = 0; axis < 3; ++axis) {
    roughness[axis] = habits.roughness(axis);
    noise[axis] = habits.noise(axis);
    extreme[axis] = habits.extreme(axis);
    step[axis] = habits.step(axis);
    for (const int sign : {1, -1}) {
      auto& limit = limits[std::size_t(2 * axis + (sign > 0 ? 0 : 1))];
      limit.reset();
      if (habits.clipped(axis, sign)) limit = habits.limit(axis, sign);
    }
  }
}

}  // namespace magimu
