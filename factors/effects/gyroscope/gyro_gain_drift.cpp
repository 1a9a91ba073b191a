// SPDX-License-Identifier: BSD-3-Clause
// (1 + sum_j k_j,i P_j(u)) times what the gyroscope reads along i: its gains change in time.
#include "factors/effects/catalogue.h"
#include "factors/effects/drift.h"

namespace magimu {

std::unique_ptr<Effect> make_gyro_gain_drift() {
  return std::make_unique<GainDrift>(
      Effect::Description{.name = "gyro_gain_drift",
                          .channel = Sensor::kGyr,
                          .cause = "the gyroscope's gain changes with time",
                          .separating_motion = "go through the same orientations early and late"},
      3);
}

}  // namespace magimu
