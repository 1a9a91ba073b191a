// SPDX-License-Identifier: BSD-3-Clause
// Packed files: zip (PKWARE's APPNOTE, stored and deflated entries, large ones too) and gzip (RFC
// 1952). What unpacks to more than a hundred times its size is no recording and is refused.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recording/files/temporary_file.h"

namespace magimu {

struct ZipEntry {
  std::string name;
  std::uint64_t packed = 0, size = 0;  // bytes
  std::uint64_t header = 0;            // where its local header is
  int method = 0;                      // 0 stored, 8 deflated
  bool encrypted = false;
};

// InputError if it is cut off or damaged.
std::vector<ZipEntry> zip_entries(const std::string& path);
TemporaryFile unpacked(const std::string& path, const ZipEntry& entry);

// All members of a gzip file. truncated: it ended too early, what came before is there.
TemporaryFile unpacked_gzip(const std::string& path, bool& truncated);

// InputError if what is unpacked so far, `size` bytes of `packed`, is more than measurements unpack
// to.
void check_ratio(const std::string& path, std::uint64_t size, std::uint64_t packed);

}  // namespace magimu
