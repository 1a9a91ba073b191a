// SPDX-License-Identifier: BSD-3-Clause
// The same effect stronger or weaker, and the size (effect_sizes.h) of those that change the noise.
#pragma once

#include <optional>

#include "tests/oracle/sensors.h"

namespace magimu {

// The effect `times` as strong: what is linear in it (or the nearest to it) is multiplied; of
// mag_saturation the depth below `largest`, the largest reading.
oracle::Effect scaled(const oracle::Effect& effect, double times, double largest = 0.0);

// Readings change in proportion to what scaled() multiplies.
bool proportional(oracle::EffectKind kind);

// size^2 of what changes the noise alone; nothing for other effects.
std::optional<double> noise_size_squared(const oracle::Effect& effect,
                                         const oracle::Options& options);

}  // namespace magimu
