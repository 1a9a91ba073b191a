// SPDX-License-Identifier: BSD-3-Clause
// m(alpha) + c for t0 <= t < t1, in n: the field about the sensor changes.
// The equations are in change.cpp; here is the one whose times are not known yet.
#include "factors/effects/catalogue.h"

namespace magimu {

std::unique_ptr<Effect> make_field_change() {
  const auto any = make_change("field_change", ChangeForm::kOffset, {});
  return std::make_unique<ChangeEffect>(*as_change(*any));
}

}  // namespace magimu
