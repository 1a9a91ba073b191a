// SPDX-License-Identifier: BSD-3-Clause
// The one door for recordings: whatever the file is, by its content and never by its name.
#pragma once

#include <string>
#include <vector>

#include "recording/csv/csv.h"

namespace magimu {

// Text (csv.h), a folder or an archive of it (several_files.h), a log (logs/), arrays of
// MATLAB, HDF5 or numpy. recording.name is the file's base name. InputError if it cannot be read;
// MissingSensor if it is but a part of a recording.
Recording read_recording(const std::string& path, const CsvOptions& options = {});

// The same of several paths: one recording each, but files that have only some of the sensors are
// joined with those after them (imu.csv and mag.csv), as long as no sensor comes twice.
std::vector<Recording> read_recordings(const std::vector<std::string>& paths,
                                       const CsvOptions& options = {});

}  // namespace magimu
