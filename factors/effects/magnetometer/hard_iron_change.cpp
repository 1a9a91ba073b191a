// SPDX-License-Identifier: BSD-3-Clause
// o_m + s for t0 <= t < t1: a magnet is attached or removed.
// The equations are in change.cpp; here is the one whose times are not known yet.
#include "factors/effects/catalogue.h"

namespace magimu {

std::unique_ptr<Effect> make_hard_iron_change() {
  const auto any = make_change("hard_iron_change", ChangeForm::kOffset, {});
  return std::make_unique<ChangeEffect>(*as_change(*any));
}

}  // namespace magimu
