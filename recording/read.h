// SPDX-License-Identifier: BSD-3-Clause
// The one door for recordings: whatever the file is, by its content and never by its name.
#pragma once

#include <string>

#include "recording/csv.h"

namespace magimu {

// An HDF5 or MAT file of the BROAD data set (broad.h), a MAT file of an array (array_mat.h), a
// phone's folder (phone_folder.h), else CSV (csv.h). `options` with names or units is for CSV only.
// recording.name is the file's base name. InputError if it cannot be read.
Recording read_recording(const std::string& path, const CsvOptions& options = {});

}  // namespace magimu
