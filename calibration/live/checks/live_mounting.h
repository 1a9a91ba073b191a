// SPDX-License-Identifier: BSD-3-Clause
// Whether the axes of a stream's sensors fit together, as `calibrate` looks at a recording's, from
// few seconds. Internal to live_checks.cpp.
#pragma once

#include <vector>

#include "calibration/trust/mounting.h"
#include "recording/checks/quality.h"

namespace magimu {

// As calibrate() looks at the axes: without repeats of slower sensors (which `issues` name), in the
// parts that gaps make.
Mounting mounting_of(Recording r, const std::vector<Issue>& issues);

// Whether length_s seconds are enough for what the mounting says.
bool sure(const Mounting& mounting, double length_s);

// Before the motion tells which axes are meant, it may tell that they are not what they are taken
// for.
std::vector<Issue> axes_that_do_not_fit(const Mounting& mounting);

}  // namespace magimu
