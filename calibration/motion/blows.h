// SPDX-License-Identifier: BSD-3-Clause
// Blows to the sensor: taps, knocks, being put down hard. No hand accelerates a sensor so that a
// reading lies 1 g beside the line through its two neighbours (a second difference of 2 g), and
// most readings around do not: what is there all the time is a vibration
// (recording/checks/check_vibration.cpp).
#pragma once

#include "recording/data/recording.h"

namespace magimu {

// Blows a minute. Samples within a tenth of a second of each other are one blow.
double blows_per_minute(const Recording& recording);

}  // namespace magimu
