// SPDX-License-Identifier: BSD-3-Clause
#include "recording/files/zstd_file.h"

#include <zstd.h>

#include <algorithm>
#include <fstream>
#include <memory>

#include "recording/data/error.h"
#include "recording/files/zip_archive.h"

namespace magimu {
namespace {

// Those with a sensor's readings have some hundred bytes.
constexpr std::uint64_t kLargestMessage = 1 << 20;

}  // namespace

TemporaryFile unpacked_zstd(const std::string& path, bool& truncated) {
  const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                             ZSTD_freeDStream);
  std::ifstream file(path, std::ios::binary);
  TemporaryFile out;
  std::string piece(ZSTD_DStreamInSize(), '\0'), unpacked(ZSTD_DStreamOutSize(), '\0');
  std::uint64_t size = 0, packed = 0;
  std::size_t left = 0;  // 0 between frames
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())), file.gcount() > 0) {
    ZSTD_inBuffer in{piece.data(), static_cast<std::size_t>(file.gcount()), 0};
    packed += in.size;
    bool more = true;  // to come out, though all is in
    while (in.pos < in.size || more) {
      ZSTD_outBuffer to{unpacked.data(), unpacked.size(), 0};
      left = ZSTD_decompressStream(stream.get(), &to, &in);
      if (ZSTD_isError(left) != 0U) {
        throw InputError(path, 0, 0, "the zstd file is damaged",
                         "give another copy of it, or what zstd -d makes of it");
      }
      size += to.pos;
      check_ratio(path, size, packed);
      out.append(std::string_view(unpacked).substr(0, to.pos));
      more = to.pos == to.size;
    }
  }
  truncated = left != 0;
  return out;
}

bool unpack_zstd_message(std::string_view packed, std::string& out) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR ||
      size > kLargestMessage) {
    return false;
  }
  out.resize(static_cast<std::size_t>(size));
  return ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size()) == out.size();
}

}  // namespace magimu
