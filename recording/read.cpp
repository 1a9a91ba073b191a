// SPDX-License-Identifier: BSD-3-Clause
// Telling the file formats apart by their signatures.
#include "recording/read.h"

#include "recording/broad.h"
#include "recording/read_file.h"

namespace magimu {

Recording read_recording(const std::string& path, const CsvOptions& options) {
  const std::string head = read_file_head(path, 16);
  if (head.starts_with("\x89HDF\r\n\x1a\n")) return read_hdf5(path);
  if (head.starts_with("MATLAB 5.0") || head.starts_with("MATLAB 7.3")) return read_mat(path);
  return read_csv(path, options);
}

}  // namespace magimu
