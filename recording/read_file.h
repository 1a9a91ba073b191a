// SPDX-License-Identifier: BSD-3-Clause
// The first step of every reader: a file's bytes, or an InputError that says why there are none.
// Readers that leave the opening to a library (HDF5, MAT) ask read_file_head first, so that a
// missing file is reported as one whatever its format.
#pragma once

#include <cstddef>
#include <string>

namespace magimu {

// All of a file, or of a pipe until its end. InputError: not there, a folder, not readable.
std::string read_file(const std::string& path);

// The first `bytes` of a regular file (fewer if it is shorter); empty for a pipe or a device, whose
// bytes could not be read a second time. InputError as above.
std::string read_file_head(const std::string& path, std::size_t bytes);

}  // namespace magimu
