// SPDX-License-Identifier: BSD-3-Clause
// Random sizes of hidden effects such as usual sensors and surroundings have.
#pragma once

#include "sim/hidden_effects.h"

namespace magimu {

// One number a parameter, times the request's factor. The same seed draws the same.
std::vector<double> realistic_size(const EffectRequest& request,
                                   const std::vector<Effect::Parameter>& parameters,
                                   const SimulatedSurroundings& where);

}  // namespace magimu
