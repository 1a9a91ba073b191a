// SPDX-License-Identifier: BSD-3-Clause
// Recordings of BROAD, a Benchmark for Robust Inertial Orientation Estimation (Laidig et al., Data
// 6(7), 2021, doi 10.3390/data6070072), as HDF5 or MAT files.
//
//   imu_acc, imu_gyr, imu_mag   N x 3   m/s^2, rad/s, uT
//   sampling_rate               scalar  Hz; in HDF5 files an attribute
//   opt_quat (w x y z), opt_pos N x 4, N x 3   optional, the cameras' orientation and position (m)
//   movement                    N       optional, true in the phase that counts in the benchmark
//
// Arrays may lie the other way round (3 x N). Sample k is at k / sampling_rate, but the
// gyroscope's half an interval earlier: its samples are means centred on their times, and Recording
// holds the start of the interval. What the cameras saw goes to recording.truth, with valid = false
// where they lost the markers (NaN in the file). An IMU sample that is not finite is left out, with
// a note.
#pragma once

#include <string>

#include "recording/csv/csv.h"

namespace magimu {

// Both throw InputError: no such file, another or a damaged format, missing or misshapen fields.
// They may be called from several threads; the HDF5 library then serves one after the other.
// Other files of named arrays are read by arrays/arrays.h, with these options.
Recording read_hdf5(const std::string& path, const CsvOptions& options);
// Versions 5 to 7.3; the latter are HDF5 inside.
Recording read_mat(const std::string& path, const CsvOptions& options);
inline Recording read_hdf5(const std::string& path) { return read_hdf5(path, {}); }
inline Recording read_mat(const std::string& path) { return read_mat(path, {}); }

}  // namespace magimu
