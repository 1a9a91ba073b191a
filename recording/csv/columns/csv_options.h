// SPDX-License-Identifier: BSD-3-Clause
// What may be said of a text file that it does not say itself.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace magimu {

struct CsvOptions {
  // A file without magnetometer samples is an error. Default true.
  bool require_mag = true;
  // A file without accelerometer or gyroscope samples is an error. Default true; false for one file
  // of several that make a recording.
  bool require_imu = true;
  // The file's column name -> ours ("t", "acc_x", "mag2_z", "temp", ...), for headers that no
  // alias covers. Default none. An entry wins over names and aliases.
  std::map<std::string, std::string> columns;
  // The file's units in ours: 1e-3 for milliseconds, 9.80665 for g, pi/180 for deg/s, 100 for
  // gauss (units.h). Default: what the header says ("Gyroscope x (deg/s)"), else s, m/s^2, rad/s,
  // uT.
  std::optional<double> time_unit, acc_unit, gyr_unit, mag_unit;
  // Samples a second, for a file without times, or with a counter of samples in their place: the
  // times are k / rate_hz. Default: the file has times.
  std::optional<double> rate_hz;
  // Times stay as large as they are, and a clock that was set back is an error: for files of one
  // sensor each that share a clock. Default false.
  bool keep_origin = false;
  // The header that a file lacks, "t,acc_x,acc_y,...", in our names or the file's; a column named -
  // or with an empty name is ignored. Default: the file has one.
  std::string header;
  // The sensor whose file it is ("acc", "gyr", "mag"): columns that are only called x, y, z are
  // read as this sensor's. Default: none, and such columns are ignored.
  std::string sensor;
  // Which sensors of a log, or files of a folder, to read where there are several of a kind: names
  // as `magimu info` lists them ("/imu/data", "mag=sensor_mag[1]"). Default: the best of each kind.
  std::vector<std::string> sensors;
};

}  // namespace magimu
