// SPDX-License-Identifier: BSD-3-Clause
// o_m + sum_j c_j P_j(u): the magnetometer's bias changes in time.
#include "factors/effects/catalogue.h"
#include "factors/effects/drift.h"

namespace magimu {

std::unique_ptr<Effect> make_hard_iron_drift() {
  return std::make_unique<BiasDrift>(
      Effect::Description{.name = "hard_iron_drift",
                          .channel = Sensor::kMag,
                          .cause = "the magnetometer's bias changes with time",
                          .separating_motion = "go through the same orientations early and late",
                          .without_attitude = true},
      3, "uT", 3.0);
}

}  // namespace magimu
