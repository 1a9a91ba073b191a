// SPDX-License-Identifier: BSD-3-Clause
// What phone apps export: a folder (unpack the zip) with one CSV file a sensor, each with times of
// its own from a common start. phyphox: "Time (s)","Acceleration x (m/s^2)", ...; Sensor Logger:
// time,seconds_elapsed,z,y,x. Of several files for one sensor the one that is nearest to what was
// measured is taken: acceleration with gravity (TotalAcceleration, or AccelerometerUncalibrated),
// magnetometer and gyroscope before the phone's own corrections. recording.notes tells which.
#pragma once

#include <string>

#include "recording/csv.h"

namespace magimu {

// Whether the path is a folder with such files for all three sensors.
bool is_phone_folder(const std::string& path);

// options: units only; names are those of the apps. InputError as read_csv, naming the file.
Recording read_phone_folder(const std::string& path, const CsvOptions& options = {});

}  // namespace magimu
