// SPDX-License-Identifier: BSD-3-Clause
// Readings that are rounded more coarsely than they are noisy: a logger that writes two digits, a
// converter with few bits. Noise of half a step and more makes rounding another noise; with less of
// it a reading stays where it is until the next step, and its error with it.
#pragma once

#include <optional>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// The step of each axis, in the unit of the readings; 0 where an axis never changes. Nothing where
// noise takes care of the rounding, or where the readings are multiples of no step.
std::optional<Vector3> coarse_steps(const VectorSeries& series);

}  // namespace magimu
