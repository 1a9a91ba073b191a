// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/spoken_names.h"

namespace magimu {

std::string spoken_name(Key key) {
  switch (key.symbol) {
    case 'R':
      return "the orientation";
    case 'a':
      return "the accelerometer bias";
    case 'w':
      return "the gyroscope bias";
    case 'D':
      return "the distortion matrix";
    case 'm':
      return "the magnetometer bias";
    case 'i':
      return "the dip";
    case 'l':
      return "the magnetometer's lag";
    case 'S':
      return "the gyroscope's scale and misalignment";
    case 'V':
      return "the velocity";
    case 'P':
      return "the position";
    case 'r':
      return "the lever arm";
    case 'e':
      return "a model extension";
    default:
      return to_string(key);
  }
}

}  // namespace magimu
