// SPDX-License-Identifier: BSD-3-Clause
// The parameters' order in the covariance, and their names and units as users meet them.
#pragma once

#include <string>
#include <vector>

#include "graph/key.h"

namespace magimu {

// acc_bias, gyr_bias, then distortion and bias of each magnetometer, then the dips, then (where it
// is estimated) the lag of each magnetometer.
std::vector<Key> parameter_keys(int magnetometers, int recordings, bool mag_time_offset);

// One name a degree of freedom, in the order of parameter_keys: "accelerometer.bias[0]",
// "magnetometers[0].distortion[row][column]", "field.dip_deg" ("fields[i].dip_deg" with several
// recordings), "magnetometers[0].time_offset_s".
std::vector<std::string> parameter_names(int magnetometers, int recordings, bool mag_time_offset);

}  // namespace magimu
