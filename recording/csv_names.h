// SPDX-License-Identifier: BSD-3-Clause
// What a column's header means: our own names, and those that phyphox, Sensor Logger, Physics
// Toolbox, ROS and plain loggers write, with the unit where the header has one:
//
//   "Gyroscope x (rad/s)" -> gyr_x     "totalAcceleration_x" -> acc_x    "time_ms" -> t, 1e-3
//   "gyro_z_dps" -> gyr_z, pi/180      "Magnetic field y (µT)" -> mag_y  "gFx" -> acc_x, 9.80665
#pragma once

#include <string>
#include <string_view>

namespace magimu {

struct CsvName {
  std::string name;  // ours; empty: none
  // Of several columns for one quantity the one with the highest: acceleration with gravity before
  // acceleration without, readings as measured before those a phone has corrected.
  int preference = 0;
  double unit = 1.0;      // the header's unit in ours
  std::string unit_text;  // as in the header; empty: it names none
  bool unknown_unit = false;
};

CsvName csv_name(std::string_view header);

}  // namespace magimu
