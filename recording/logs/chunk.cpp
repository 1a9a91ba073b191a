// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/chunk.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>

#include "graph/parallel.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

constexpr std::uint64_t kLargestChunk = 1ULL << 28;  // bytes; writers' default is below 1 MB
// Messages with many zeros (covariances) pack well; nothing a logger writes packs better.
constexpr std::uint64_t kBestRatio = 1000;
// Eight chunks of the usual size: enough for the cores there are, and no burden for the memory.
constexpr std::size_t kMostWaiting = 8;
constexpr std::uint64_t kMostWaitingBytes = 1ULL << 24;

bool unpack_bz2(std::string_view packed, std::string& out) {
  auto size = static_cast<unsigned>(out.size());
  const int status = BZ2_bzBuffToBuffDecompress(out.data(), &size, const_cast<char*>(packed.data()),
                                                static_cast<unsigned>(packed.size()), 0, 0);
  return status == BZ_OK && size == out.size();
}

bool unpack_lz4(std::string_view packed, std::string& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0U) return false;
  std::size_t read = 0, written = 0, status = 1;
  while (status != 0 && read < packed.size()) {
    std::size_t in = packed.size() - read, to = out.size() - written;
    status =
        LZ4F_decompress(context, out.data() + written, &to, packed.data() + read, &in, nullptr);
    if (LZ4F_isError(status) != 0U || (in == 0 && to == 0)) break;
    read += in;
    written += to;
  }
  LZ4F_freeDecompressionContext(context);
  return written == out.size();
}

}  // namespace

bool may_unpack_to(std::uint64_t packed, std::uint64_t size) {
  return size <= kLargestChunk && size <= kBestRatio * (packed + 100);
}

bool unpack_chunk(const std::string& method, std::string_view packed, std::uint64_t size,
                  std::string& out, const std::string& path) {
  if (method != "bz2" && method != "lz4" && method != "zstd" && method != "none" &&
      !method.empty()) {
    throw InputError(path, 0, 0, "its chunks are packed by " + quoted_text(method),
                     "convert it (rosbag decompress, ros2 bag convert, mcap compress)");
  }
  if (method == "none" || method.empty()) {
    out.assign(packed);
    return true;
  }
  if (!may_unpack_to(packed.size(), size)) return false;
  out.resize(size);
  if (size == 0) return true;
  if (method == "bz2") return unpack_bz2(packed, out);
  if (method == "lz4") return unpack_lz4(packed, out);
  return ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size()) == out.size();
}

void ChunkQueue::add(const std::string& method, std::string_view packed, std::uint64_t size) {
  if (method == "none" || method.empty()) {
    finish();
    take_(packed, true);
    return;
  }
  if (used_ == chunks_.size()) chunks_.emplace_back();
  Chunk& chunk = chunks_[used_++];
  chunk.method = method;
  chunk.packed.assign(packed);
  chunk.size = size;
  waiting_ += packed.size() + std::min(size, kLargestChunk);
  if (used_ == kMostWaiting || waiting_ >= kMostWaitingBytes) finish();
}

void ChunkQueue::finish() {
  parallel::for_each(used_, [this](std::size_t i) {
    Chunk& chunk = chunks_[i];
    chunk.whole = unpack_chunk(chunk.method, chunk.packed, chunk.size, chunk.unpacked, path_);
  });
  for (std::size_t i = 0; i < used_; ++i) take_(chunks_[i].unpacked, chunks_[i].whole);
  // A chunk that was far larger than usual gives its memory back.
  if (waiting_ > 2 * kMostWaitingBytes) chunks_.clear();
  used_ = 0;
  waiting_ = 0;
}

}  // namespace magimu
