// SPDX-License-Identifier: BSD-3-Clause
// The first step of every reader: a file's bytes, or an InputError that says why there are none.
// Readers that leave the opening to a library (HDF5, MAT) ask read_file_head first, so that a
// missing file is reported as one whatever its format.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace magimu {

// All of a file, or of a pipe until its end. InputError: not there, a folder, not readable, a pipe
// or a device without an end.
std::string read_file(const std::string& path);

// The same piece by piece, for what may be longer than memory or without an end: use(piece, size),
// size that of the whole file in bytes, 0 for a pipe or a device.
void read_file_in_pieces(const std::string& path,
                         const std::function<void(std::string_view, std::size_t)>& use);

// Neither a regular file nor a folder: its bytes can be read once, and only until it ends.
bool is_pipe_or_device(const std::string& path);

// The first `bytes` of a regular file (fewer if it is shorter); empty for a pipe or a device, whose
// bytes could not be read a second time. InputError as above.
std::string read_file_head(const std::string& path, std::size_t bytes);

}  // namespace magimu
