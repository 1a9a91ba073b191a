// SPDX-License-Identifier: BSD-3-Clause
// Files and messages that are packed by zstd: CSV.zst, the .db3.zstd and .mcap.zstd of ROS 2, and
// its messages where each is packed by itself.
#pragma once

#include <string>
#include <string_view>

#include "recording/files/temporary_file.h"

namespace magimu {

inline constexpr std::string_view kZstdMagic = "\x28\xB5\x2F\xFD";

// truncated: whether it is cut off; what is before the cut is unpacked. InputError if it is damaged
// or unpacks to far more than measurements do (zip_archive.h).
TemporaryFile unpacked_zstd(const std::string& path, bool& truncated);

// A message, into `out`. False if it is damaged, or larger than a message can be.
bool unpack_zstd_message(std::string_view packed, std::string& out);

}  // namespace magimu
