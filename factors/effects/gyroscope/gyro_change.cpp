// SPDX-License-Identifier: BSD-3-Clause
// gyr + C (omega + o_w) for t0 <= t < t1: the gyroscope's gains, misalignment or mounting
// change.
// The equations are in change.cpp; here is the one whose times are not known yet.
#include "factors/effects/catalogue.h"

namespace magimu {

std::unique_ptr<Effect> make_gyro_change() {
  const auto any = make_change("gyro_change", ChangeForm::kMatrix, {});
  return std::make_unique<ChangeEffect>(*as_change(*any));
}

}  // namespace magimu
