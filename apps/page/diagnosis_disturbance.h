// SPDX-License-Identifier: BSD-3-Clause
// The picture of what the simulation lacks: the smoothed disturbance against time, with its band.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

// One chart an axis, as SVG.
std::string disturbance_picture(const MissingSeries& series);
// The caption below it.
std::string disturbance_caption(const MissingSeries& series);

// The field's departure against the place, along the direction in which it changes most.
std::string place_picture(const PlaceCheck& place);
std::string place_caption(const PlaceCheck& place);
// The results of the place's tests (a), (b) and (c), one sentence each.
std::vector<std::string> place_words(const Diagnosis& d);

}  // namespace magimu::apps
