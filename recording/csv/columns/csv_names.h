// SPDX-License-Identifier: BSD-3-Clause
// What a column's header means: our own names, and those that phyphox, Sensor Logger, Physics
// Toolbox, ROS and plain loggers write, with the unit where the header has one:
//
//   "Gyroscope x (rad/s)" -> gyr_x     "totalAcceleration_x" -> acc_x    "time_ms" -> t, 1e-3
//   "gyro_z_dps" -> gyr_z, pi/180      "Magnetic field y (µT)" -> mag_y  "gFx" -> acc_x, 9.80665
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace magimu {

struct CsvName {
  std::string name;  // ours; empty: none
  // Of several columns for one quantity the one with the highest preference is read: acceleration
  // with gravity rather than without, readings as measured rather than corrected by a phone.
  int preference = 0;
  double unit = 1.0;      // the header's unit in ours
  std::string unit_text;  // as in the header; empty: it names none
  bool unknown_unit = false;
  bool unit_of_word = false;  // the header names no unit; its word usually has this one
  bool uncalibrated = false;  // the header says that the device has not corrected these readings
};

CsvName csv_name(std::string_view header);

// The sensor whose own time a column is: "acc_time" -> "acc"; empty if it is none.
std::string csv_time_of(std::string_view header);

// Headers with numbers replaced by axes where three belong together: "gyro_rad[0]", [1], [2] and
// "acc_1", "acc_2", "acc_3" then end in x, y, z. Other headers stay as they are.
std::vector<std::string> with_axes_for_numbers(std::vector<std::string> headers);

}  // namespace magimu
