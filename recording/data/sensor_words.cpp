// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/sensor_words.h"

namespace magimu {

const char* sensor_in_words(std::string_view sensor) {
  return sensor == "acc" ? "accelerometer" : sensor == "gyr" ? "gyroscope" : "magnetometer";
}

}  // namespace magimu
