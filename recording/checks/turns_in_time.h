// SPDX-License-Identifier: BSD-3-Clause
// A gyroscope that seems to be in another unit, where it is the times that are: rates are angles
// over times, and both look alike to the other sensors' directions.
#pragma once

#include <optional>

#include "recording/checks/quality.h"

namespace magimu {

// gain: what the gyroscope reads over the rate at which directions turn, by the recording's times.
// explained: a unit, a range or a converter's counts would make such a gain. The issue of another
// unit of time, where that is the likelier cause: the rates that a gyroscope in another unit would
// have measured are beyond all gyroscopes, or nothing explains the gain and the unit of time would
// be a usual one. Nothing where the gyroscope's unit is the likelier one.
std::optional<Issue> time_unit_of_turns(const Recording& r, double gain, bool explained);

}  // namespace magimu
