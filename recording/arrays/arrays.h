// SPDX-License-Identifier: BSD-3-Clause
// Arrays with names, of numpy, MATLAB or HDF5 files, as a recording: an N x 3 (or 3 x N) array that
// is called as a sensor, "acc" or "imu.gyro"; a time of as many numbers, "t" or "timestamps"; else
// a rate in Hz ("fs", "sampling_rate") or an interval in s ("Ts", "dt").
#pragma once

#include <string>

#include "recording/arrays/broad_fields.h"
#include "recording/csv/csv.h"

namespace magimu {

// options.columns: an array's name -> "acc", "gyr", "mag", "t" (or "mag2", ...); units and rate as
// for text. InputError names the arrays that are there.
Recording recording_from_arrays(const BroadFile& file, const CsvOptions& options);

// numpy's files (.npy and .npz); a structured array's fields are arrays of their own.
Recording read_npy(const std::string& path, const CsvOptions& options);

// The fields of one .npy file are added to `file`, in front of their names `name`. content must
// live as long as `file` is read from. InputError if it is damaged.
void add_npy(const std::string& content, const std::string& name, BroadFile& file);

}  // namespace magimu
