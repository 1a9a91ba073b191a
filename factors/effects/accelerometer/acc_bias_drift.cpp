// SPDX-License-Identifier: BSD-3-Clause
// o_a + sum_j c_j P_j(u): the accelerometer's bias changes in time, as where it warms up.
#include "factors/effects/catalogue.h"
#include "factors/effects/drift.h"

namespace magimu {

std::unique_ptr<Effect> make_acc_bias_drift() {
  return std::make_unique<BiasDrift>(
      Effect::Description{.name = "acc_bias_drift",
                          .channel = Sensor::kAcc,
                          .cause = "the accelerometer's bias changes with time",
                          .separating_motion = "hold every face of the sensor up, early and late",
                          .without_attitude = true},
      3, "m/s^2", 0.05);
}

}  // namespace magimu
