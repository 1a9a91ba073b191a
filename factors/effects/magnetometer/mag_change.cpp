// SPDX-License-Identifier: BSD-3-Clause
// mag + C (B + o_m) for t0 <= t < t1: the magnetometer's gains, misalignment or mounting change.
// The equations are in change.cpp; here is the one whose times are not known yet.
#include "factors/effects/catalogue.h"

namespace magimu {

std::unique_ptr<Effect> make_mag_change() {
  const auto any = make_change("mag_change", ChangeForm::kMatrix, {});
  return std::make_unique<ChangeEffect>(*as_change(*any));
}

}  // namespace magimu
