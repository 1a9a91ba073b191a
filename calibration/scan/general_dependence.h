// SPDX-License-Identifier: BSD-3-Clause
// Dependences of a reading on what the sensor experiences, without a physical cause of that shape.
#pragma once

#include <memory>
#include <vector>

#include "factors/effects/effect.h"

namespace magimu {

// Each an "effect" whose cause says what it depends on, in words: "on products of the field's
// directions".
std::vector<std::shared_ptr<const Effect>> general_dependences(bool moving);
// On what another sensor reads: of crosstalk. (A hand that turns the sensor moves it, too, so that
// these do not tell whether it was moved.)
std::vector<std::shared_ptr<const Effect>> dependences_on_other_sensors();
// Is it the one of general_dependences() that depends on time, whatever the sensor experiences?
bool depends_on_time(const Effect& dependence);

// A sensor's bias that is another one in each of `windows` windows of the recording, or of a part
// of it (u: -1 at the start, 1 at the end; zero outside): 3 parameters each.
std::shared_ptr<const Effect> bias_in_windows(int windows, Sensor channel = Sensor::kMag,
                                              double u_begin = -1.0, double u_end = 1.0);

}  // namespace magimu
