// SPDX-License-Identifier: BSD-3-Clause
// o_a + s for t0 <= t < t1: the accelerometer's bias changes at once.
// The equations are in change.cpp; here is the one whose times are not known yet.
#include "factors/effects/catalogue.h"

namespace magimu {

std::unique_ptr<Effect> make_acc_bias_change() {
  const auto any = make_change("acc_bias_change", ChangeForm::kOffset, {});
  return std::make_unique<ChangeEffect>(*as_change(*any));
}

}  // namespace magimu
