// SPDX-License-Identifier: BSD-3-Clause
// Several devices whose files lie in one folder (MetaWear: "MetaWear_2023-05-01_C8F4_Gyroscope.csv"
// beside "..._D1A2_Gyroscope.csv"): a recording is made of the files of one device.
#pragma once

#include <string>
#include <vector>

#include "recording/csv/csv.h"

namespace magimu {

// Of what the files of one folder hold (Recording::name is the file's) that of one device: of the
// one that is chosen by --sensor, else of the one with the most sensors, else of the first. Files
// whose names tell of no device stay, and those that are chosen. Notes say which files are left
// out. InputError where only the files of two devices together have all sensors.
std::vector<Recording> of_one_device(std::vector<Recording> parts, const std::string& path,
                                     const CsvOptions& options, std::vector<std::string>& notes);

// Whether two files are of different devices, as their names say: they differ in one word, which
// looks like a device's own ("C8F4", "IMU1").
bool differ_in_device(const std::string& name, const std::string& other);

}  // namespace magimu
