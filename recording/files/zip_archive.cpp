// SPDX-License-Identifier: BSD-3-Clause
#include "recording/files/zip_archive.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

// Rows of measured numbers pack to a fifth, the most repetitive ones to a thirtieth.
constexpr std::uint64_t kMostRatio = 100, kAlways = 1 << 20;
constexpr std::size_t kUnpackPiece = 1 << 18;
constexpr std::string_view kGzipMark = "\x1f\x8b";
constexpr std::size_t kMostEntries = 65536;

std::uint64_t little(const char* at, int bytes) {
  std::uint64_t value = 0;
  for (int i = bytes; i-- > 0;) value = value << 8 | static_cast<unsigned char>(at[i]);
  return value;
}

[[noreturn]] void damaged_zip(const std::string& path, const std::string& what) {
  throw InputError(path, 0, 0, "the zip archive is damaged or cut off: " + what,
                   "give another copy of it, or unpack it and give the folder");
}

[[noreturn]] void refuse_bomb(const std::string& path, std::uint64_t size, std::uint64_t packed) {
  throw InputError(path, 0, 0,
                   fmt::format("it unpacks to more than {} times its size ({} bytes of {}): no "
                               "measurements pack so well",
                               kMostRatio, size, packed),
                   "unpack it yourself if it is what you expect");
}

std::string bytes_at(std::ifstream& file, std::uint64_t at, std::size_t count) {
  std::string out(count, '\0');
  file.clear();
  file.seekg(static_cast<std::streamoff>(at));
  file.read(out.data(), static_cast<std::streamsize>(count));
  out.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return out;
}

// zlib's state, ended whatever happens.
class Inflater {
 public:
  explicit Inflater(int window_bits) { ok_ = inflateInit2(&z_, window_bits) == Z_OK; }
  ~Inflater() {
    if (ok_) inflateEnd(&z_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  // Unpacks a piece into the file. The result of zlib: Z_OK while more is to come, Z_STREAM_END.
  template <class Check>
  int feed(std::string_view piece, TemporaryFile& to, const Check& check) {
    z_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
    z_.avail_in = static_cast<uInt>(piece.size());
    std::string& out = out_;
    int status = Z_OK;
    while (z_.avail_in > 0 && status == Z_OK) {
      z_.next_out = reinterpret_cast<Bytef*>(out.data());
      z_.avail_out = static_cast<uInt>(out.size());
      status = inflate(&z_, Z_NO_FLUSH);
      const std::size_t got = out.size() - z_.avail_out;
      size_ += got;
      check(size_);
      to.append(std::string_view(out).substr(0, got));
      if (status == Z_BUF_ERROR) status = Z_OK;
      if (got == 0 && z_.avail_in > 0 && status == Z_OK) break;
    }
    return status;
  }
  // Bytes of the last piece that belong to what follows.
  std::size_t left() const { return z_.avail_in; }
  void reset() { inflateReset(&z_); }

 private:
  z_stream z_{};
  std::string out_ = std::string(kUnpackPiece, '\0');
  bool ok_ = false;
  std::uint64_t size_ = 0;
};

}  // namespace

void check_ratio(const std::string& path, std::uint64_t size, std::uint64_t packed) {
  if (size > kAlways && size / kMostRatio > packed) refuse_bomb(path, size, packed);
}

std::vector<ZipEntry> zip_entries(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  // The end record lies within the last 64 kB, behind a comment.
  const std::size_t tail_size = static_cast<std::size_t>(std::min<std::uint64_t>(size, 65557));
  const std::uint64_t tail_at = size - tail_size;
  const std::string tail = bytes_at(file, tail_at, tail_size);
  const std::size_t end = tail.rfind("PK\x05\x06");
  if (end == std::string::npos || end + 22 > tail.size()) damaged_zip(path, "it has no directory");
  std::uint64_t count = little(&tail[end + 10], 2), length = little(&tail[end + 12], 4),
                at = little(&tail[end + 16], 4);
  const std::size_t locator = tail.rfind("PK\x06\x07");
  if (locator != std::string::npos && locator + 20 <= tail.size()) {
    const std::string large = bytes_at(file, little(&tail[locator + 8], 8), 56);
    if (large.size() == 56 && large.starts_with("PK\x06\x06")) {
      count = little(&large[32], 8);
      length = little(&large[40], 8);
      at = little(&large[48], 8);
    }
  }
  if (at > size || length > size - at || length > (64U << 20)) damaged_zip(path, "its directory");
  const std::string directory = bytes_at(file, at, static_cast<std::size_t>(length));
  std::vector<ZipEntry> entries;
  std::size_t i = 0;
  while (entries.size() < std::min<std::uint64_t>(count, kMostEntries)) {
    if (i + 46 > directory.size() || directory.compare(i, 4, "PK\x01\x02") != 0) {
      damaged_zip(path, "its directory");
    }
    const char* const h = &directory[i];
    const std::size_t name = little(h + 28, 2), extra = little(h + 30, 2),
                      comment = little(h + 32, 2);
    if (i + 46 + name + extra + comment > directory.size()) damaged_zip(path, "its directory");
    ZipEntry entry;
    entry.encrypted = (little(h + 8, 2) & 1U) != 0;
    entry.method = static_cast<int>(little(h + 10, 2));
    entry.packed = little(h + 20, 4);
    entry.size = little(h + 24, 4);
    entry.header = little(h + 42, 4);
    entry.name = directory.substr(i + 46, name);
    // Numbers that do not fit 32 bits are in an extra field, in this order.
    for (std::size_t e = i + 46 + name, last = e + extra; e + 4 <= last;) {
      const std::uint64_t id = little(&directory[e], 2), bytes = little(&directory[e + 2], 2);
      std::size_t value = e + 4;
      e = value + bytes;
      if (id != 1 || e > last) continue;
      for (std::uint64_t* number : {&entry.size, &entry.packed, &entry.header}) {
        if (*number != 0xFFFFFFFF || value + 8 > e) continue;
        *number = little(&directory[value], 8);
        value += 8;
      }
    }
    if (entry.header >= size || entry.packed > size) damaged_zip(path, quoted_text(entry.name));
    entries.push_back(std::move(entry));
    i += 46 + name + extra + comment;
  }
  return entries;
}

TemporaryFile unpacked(const std::string& path, const ZipEntry& entry) {
  const std::string shown = quoted_text(entry.name);
  if (entry.encrypted) {
    throw InputError(path, 0, 0, shown + " is encrypted", "unpack it with its password first");
  }
  if (entry.method != 0 && entry.method != 8) {
    throw InputError(path, 0, 0, fmt::format("{} is packed by method {}", shown, entry.method),
                     "unpack it and give the folder");
  }
  check_ratio(path, entry.size, entry.packed);
  std::ifstream file(path, std::ios::binary);
  const std::string local = bytes_at(file, entry.header, 30);
  if (local.size() < 30 || !local.starts_with("PK\x03\x04")) damaged_zip(path, shown);
  std::uint64_t at = entry.header + 30 + little(&local[26], 2) + little(&local[28], 2);
  TemporaryFile out;
  Inflater inflater(-MAX_WBITS);
  int status = entry.method == 0 || entry.packed == 0 ? Z_STREAM_END : Z_OK;
  for (std::uint64_t left = entry.packed; left > 0;) {
    std::string piece =
        bytes_at(file, at, static_cast<std::size_t>(std::min<std::uint64_t>(left, kUnpackPiece)));
    if (piece.empty()) damaged_zip(path, shown);
    at += piece.size();
    left -= piece.size();
    if (entry.method == 0) {
      out.append(piece);
      continue;
    }
    status = inflater.feed(piece, out, [&](std::uint64_t size) {
      check_ratio(path, size, entry.packed);
      if (size > entry.size) damaged_zip(path, shown + " is larger than it says");
    });
    if (status != Z_OK) break;
  }
  if (status != Z_STREAM_END) damaged_zip(path, shown);
  return out;
}

TemporaryFile unpacked_gzip(const std::string& path, bool& truncated) {
  std::ifstream file(path, std::ios::binary);
  TemporaryFile out;
  Inflater inflater(MAX_WBITS + 16);
  std::uint64_t at = 0;
  int status = Z_OK;
  std::string piece;
  std::string_view rest;  // of the piece, still packed; a member may begin anywhere in it
  while (true) {
    if (rest.size() < kGzipMark.size()) {
      const std::string more = bytes_at(file, at, kUnpackPiece);
      if (more.empty()) break;
      at += more.size();
      piece = std::string(rest) + more;
      rest = piece;
    }
    if (status == Z_STREAM_END) {  // another member, or padding
      if (!rest.starts_with(kGzipMark)) break;
      inflater.reset();
    }
    status = inflater.feed(rest, out, [&](std::uint64_t size) { check_ratio(path, size, at); });
    const bool stands = status == Z_OK && inflater.left() == rest.size();
    if (stands || (status != Z_OK && status != Z_STREAM_END)) {
      throw InputError(path, 0, 0, "the gzip file is damaged",
                       "give another copy of it, or what gunzip makes of it");
    }
    rest.remove_prefix(rest.size() - inflater.left());
  }
  truncated = status != Z_STREAM_END;
  return out;
}

}  // namespace magimu
