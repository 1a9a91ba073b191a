// SPDX-License-Identifier: BSD-3-Clause
// Blows to the sensor: taps, knocks, being put down hard. No hand accelerates a sensor so that the
// reading leaves the line through its neighbours by 2 g between samples.
#pragma once

#include "recording/recording.h"

namespace magimu {

// A minute; samples within a tenth of a second of each other are one blow.
double blows_per_minute(const Recording& recording);

}  // namespace magimu
