// SPDX-License-Identifier: BSD-3-Clause
// Output files are written whole or not at all: a reader never meets half a calibration, and a full
// disk or a power cut leaves the previous file as it was.
#pragma once

#include <string>
#include <string_view>

namespace magimu {

// Writes a temporary file into the target's folder, waits until it is on the disk, and renames it
// over the target. A symbolic link stays one and its target is replaced; an existing file keeps its
// permissions. What is not a regular file (/dev/stdout, a pipe, a terminal) is written directly.
// InputError with a remedy if that fails; nothing is then left behind. What runs that were killed
// have left in the folder is removed.
void write_atomically(const std::string& path, std::string_view content);

}  // namespace magimu
