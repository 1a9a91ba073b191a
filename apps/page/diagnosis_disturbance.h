// SPDX-License-Identifier: BSD-3-Clause
// The picture of what the simulation lacks: the smoothed disturbance against time, with its band.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

// One chart an axis, as SVG.
std::string disturbance_picture(const MissingSeries& series);
// Under it.
std::string disturbance_caption(const MissingSeries& series);

}  // namespace magimu::apps
