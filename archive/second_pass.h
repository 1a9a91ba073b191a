// SPDX-License-Identifier: BSD-3-Clause
// Recordings that tell too little by themselves: a turn about one axis, some seconds. Their own fit
// ends anywhere along what the motion leaves open, and a summary that is linearized there says
// nothing right. So they are fitted again with the parameters held where the device is known to be
// (calibrate_condensed_at()), and what they say about those parameters is added to the others.
#pragma once

#include "archive/device.h"

namespace magimu {

// Its verdict is no: it tells too little, or something is wrong with it. What is wrong shows at the
// device's parameters, too, and that verdict decides.
bool is_no_by_itself(const DeviceRecording& recording);

// Where the recordings that tell enough say that the device is; nothing where none does, or where
// they look as if they were of several devices.
std::optional<Calibration> device_by_the_others(const std::string& name,
                                                const std::vector<DeviceRecording>& recordings);

// `recording` as its fit at the device's parameters has it. second: that fit, with its summary.
void take_second_pass(DeviceRecording& recording, DeviceRecording second);

}  // namespace magimu
