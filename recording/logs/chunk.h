// SPDX-License-Identifier: BSD-3-Clause
// Chunks of logs, unpacked: bz2, lz4 (frames) and zstd. No more than the size that is claimed, and
// that no more than the packed bytes can hold.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

// Into `out`, `size` bytes (claimed by the file). False if the chunk is damaged, or the claim
// impossible. method: "none", "", "bz2", "lz4", "zstd"; any other: InputError naming `path`.
bool unpack_chunk(const std::string& method, std::string_view packed, std::uint64_t size,
                  std::string& out, const std::string& path);

// May so many packed bytes hold so many?
bool may_unpack_to(std::uint64_t packed, std::uint64_t size);

// Chunks that are unpacked side by side, and taken in the file's order: bzip2 needs longer for its
// bytes than all else that a log is read by. A few MB at a time are in memory.
class ChunkQueue {
 public:
  // Gets the bytes of a chunk, or that it is damaged.
  using Take = std::function<void(std::string_view bytes, bool whole)>;
  ChunkQueue(const std::string& path, Take take) : path_(path), take_(std::move(take)) {}

  void add(const std::string& method, std::string_view packed, std::uint64_t size);
  // All that were added are unpacked and taken.
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
