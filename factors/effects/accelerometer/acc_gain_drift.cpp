// SPDX-License-Identifier: BSD-3-Clause
// (1 + sum_j k_j,i P_j(u)) times what the accelerometer reads along i: its gains change in time.
#include "factors/effects/catalogue.h"
#include "factors/effects/drift.h"

namespace magimu {

std::unique_ptr<Effect> make_acc_gain_drift() {
  return std::make_unique<GainDrift>(
      Effect::Description{.name = "acc_gain_drift",
                          .channel = Sensor::kAcc,
                          .cause = "the accelerometer's gain changes with time",
                          .separating_motion = "go through the same orientations early and late"},
      3, 0);
}

}  // namespace magimu
