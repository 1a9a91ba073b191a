// SPDX-License-Identifier: BSD-3-Clause
// Unpacks chunks of logs: bz2, lz4 (frames) and zstd. A chunk is never unpacked to more than the
// size that the file claims, and that size must be possible for the packed bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

// Unpacks to `out`, which gets `size` bytes (the file's claim). False if the chunk is damaged or
// the claim impossible. `method`: "none", "", "bz2", "lz4" or "zstd"; any other throws InputError
// with `path`.
bool unpack_chunk(const std::string& method, std::string_view packed, std::uint64_t size,
                  std::string& out, const std::string& path);

// Whether `packed` bytes can hold `size` bytes.
bool may_unpack_to(std::uint64_t packed, std::uint64_t size);

// Unpacks several chunks in parallel and hands them over in the file's order. (bzip2 takes longer
// than all other steps of reading a log.) A few MB are in memory at a time.
class ChunkQueue {
 public:
  // Receives the bytes of each chunk; `whole` is false for a damaged one.
  using Take = std::function<void(std::string_view bytes, bool whole)>;
  ChunkQueue(const std::string& path, Take take) : path_(path), take_(std::move(take)) {}

  void add(const std::string& method, std::string_view packed, std::uint64_t size);
  // Unpacks and hands over all chunks that are left.
  void finish();

 private:
  struct Chunk {
    std::string method, packed, unpacked;
    std::uint64_t size = 0;
    bool whole = false;
  };
  const std::string& path_;
  Take take_;
  std::vector<Chunk> chunks_;  // the first used_ of them wait; the others keep their memory
  std::size_t used_ = 0;
  std::uint64_t waiting_ = 0;  // bytes, packed and unpacked
};

}  // namespace magimu
