// SPDX-License-Identifier: BSD-3-Clause
// What a fitted model lacks, whatever its cause, and where the calibration would be with it: the
// disturbance that gains most evidence (disturbance.h), in the field, the magnetometer, the
// gyroscope or the accelerometer. A cause that is in no catalogue, or that begins and ends as it
// likes, moves a calibration as much as one that has a name.
#pragma once

#include <optional>

#include "calibration/scan/missing_effects.h"

namespace magimu {

// Nothing where no disturbance gains more than chance does (kNullGain), or where the recording has
// so many nodes that it would take longer than the fit.
std::optional<MissingEffect> find_lacking_state(const Stage& stage);

}  // namespace magimu
