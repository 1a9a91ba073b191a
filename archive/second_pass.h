// SPDX-License-Identifier: BSD-3-Clause
// Devices of which no recording tells enough by itself: turns about one axis, some seconds. Such a
// fit ends anywhere along what the motion leaves open, and a summary that is linearized there says
// nothing right. So they are fitted again with the parameters held where all of them together say
// that the device is (calibrate_condensed_at()), and what each says about those is added up. (Where
// a recording tells enough, they could add little, and what is wrong with them much.)
#pragma once

#include "archive/device.h"

namespace magimu {

// There are several with a fit, and the verdict of each is no.
bool none_tells_enough(const std::vector<DeviceRecording>& recordings);

// `recording` as its fit at the device's parameters has it. second: that fit, with its summary.
void take_second_pass(DeviceRecording& recording, DeviceRecording second);

}  // namespace magimu
