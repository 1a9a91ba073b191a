// SPDX-License-Identifier: BSD-3-Clause
// Telling the file formats apart by their signatures.
#include "recording/read.h"

#include "recording/broad.h"
#include "recording/error.h"
#include "recording/phone_folder.h"
#include "recording/read_file.h"

namespace magimu {
namespace {

// Options for CSV would go unheard with other files.
void refuse_csv_options(const std::string& path, const CsvOptions& options) {
  if (options.columns.empty() && !options.time_unit && !options.acc_unit && !options.gyr_unit &&
      !options.mag_unit && !options.rate_hz) {
    return;
  }
  throw InputError(path, 0, 0,
                   "this is an HDF5 or MAT file of the BROAD data set, whose names and units are "
                   "fixed (m/s^2, rad/s, uT)",
                   "give no mapping of columns (--map), no units (--unit) and no --rate with it");
}

}  // namespace

Recording read_recording(const std::string& path, const CsvOptions& options) {
  if (is_phone_folder(path)) return read_phone_folder(path, options);
  const std::string head = read_file_head(path, 16);
  const bool hdf5 = head.starts_with("\x89HDF\r\n\x1a\n");
  const bool mat = head.starts_with("MATLAB 5.0") || head.starts_with("MATLAB 7.3");
  if (!hdf5 && !mat) return read_csv(path, options);
  refuse_csv_options(path, options);
  return hdf5 ? read_hdf5(path) : read_mat(path);
}

}  // namespace magimu
