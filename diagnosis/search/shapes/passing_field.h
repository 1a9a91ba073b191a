// SPDX-License-Identifier: BSD-3-Clause
// Something magnetic that comes near and goes again, for comparison: within a span the magnetometer
// reads more by a polynomial of time on each axis. It has nine numbers, as many as a change of
// gains, and no physical model.
#pragma once

#include <memory>

#include "factors/effects/change.h"

namespace magimu {

// mag + sum over j = 0, 1, 2 of s_j P_j(u), u from -1 to 1 within the span. Both ends are finite
// and of one recording. beside_the_sensor: s_j in its frame, uT, as where a magnet is brought near
// it; else D R' times that, in n and in shares of the field, as where a car passes.
std::shared_ptr<const Effect> make_passing_field(const ChangeSpan& span, bool beside_the_sensor);

}  // namespace magimu
