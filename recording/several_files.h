// SPDX-License-Identifier: BSD-3-Clause
// Folders and archives that loggers write, one file a sensor or a topic: phyphox, Sensor Logger,
// ulog2csv, mavlogdump. Files are known by what is in them, and where their columns are just x, y,
// z, by their names. Of several for one sensor the one nearest to what was measured is taken:
// acceleration with gravity, magnetometer and gyroscope before a phone's own corrections.
#pragma once

#include <string>
#include <vector>

#include "recording/csv/csv.h"

namespace magimu {

struct NamedFile {
  std::string path;
  std::string name;  // for messages, and for what it tells: "Gyroscope.csv"
};

// path: of the folder or archive, for messages. InputError if none of them, or not all that
// options require, are there.
Recording read_several(const std::vector<NamedFile>& files, const std::string& path,
                       const CsvOptions& options);

// The files right in a folder.
std::vector<NamedFile> files_of_folder(const std::string& path);

// Whether its files' names say that each has one sensor, of accelerometer, gyroscope and
// magnetometer: one recording then.
bool is_folder_of_sensors(const std::string& path);

// The sensor that a file's name says is in it, such as "mag" of "MagnetometerUncalibrated.csv" and
// "log_5_sensor_mag_0.csv"; empty if none.
std::string sensor_of_name(const std::string& name);

// Whether --sensor names this file.
bool is_chosen_file(const std::string& name, const CsvOptions& options);

}  // namespace magimu
