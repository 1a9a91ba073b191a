// SPDX-License-Identifier: BSD-3-Clause
// The sensors' short names in words.
#pragma once

#include <string_view>

namespace magimu {

// "acc" -> "accelerometer", "gyr" -> "gyroscope"; every other one is a magnetometer.
const char* sensor_in_words(std::string_view sensor);

}  // namespace magimu
