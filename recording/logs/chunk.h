// SPDX-License-Identifier: BSD-3-Clause
// Chunks of logs, unpacked: bz2, lz4 (frames) and zstd. No more than the size that is claimed, and
// that no more than the packed bytes can hold.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace magimu {

// Into `out`, `size` bytes (claimed by the file). False if the chunk is damaged, or the claim
// impossible. method: "none", "", "bz2", "lz4", "zstd"; any other: InputError naming `path`.
bool unpack_chunk(const std::string& method, std::string_view packed, std::uint64_t size,
                  std::string& out, const std::string& path);

}  // namespace magimu
