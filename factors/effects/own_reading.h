// SPDX-License-Identifier: BSD-3-Clause
// All that a sensor reads, its bias too: what a gain multiplies.
#pragma once

#include "factors/effects/effect.h"

namespace magimu {

inline Vector3 own_reading(const SampleState& s, Sensor channel) {
  if (channel == Sensor::kAcc) return s.f + s.bias;
  return channel == Sensor::kGyr ? Vector3(s.omega + s.bias) : Vector3(s.D * s.b + s.bias);
}

}  // namespace magimu
