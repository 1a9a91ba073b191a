// SPDX-License-Identifier: BSD-3-Clause
// The file is a chain of elements: a type, a length, and that many bytes. A variable is one
// element, plain (its parts are elements again: flags, dimensions, name, values) or packed by zlib.
#include "recording/mat_elements.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

namespace magimu {
namespace {

constexpr std::size_t kHeader = 128, kTag = 8;
constexpr std::uint32_t kMatrix = 14, kPacked = 15;      // types of elements
constexpr std::uint32_t kSparse = 5, kFirstNumeric = 6;  // classes of matrices
constexpr int kDeepest = 16;                             // matrices within structures within ...
constexpr std::size_t kDensest = 1032;         // zlib packs at most so many bytes into one
constexpr std::size_t kFirstParts = 4096;      // flags, dimensions and name are in these
constexpr std::size_t kNestedLimit = 1 << 26;  // bytes of structures, which are nothing of ours

// The numbers of a file, in its own byte order; 0 where there are none.
class Numbers {
 public:
  Numbers(std::string_view content, bool swapped) : content_(content), swapped_(swapped) {}
  std::uint32_t at(std::size_t position) const {
    std::uint32_t value = 0;
    if (position + sizeof value <= content_.size()) {
      std::memcpy(&value, content_.data() + position, sizeof value);
    }
    return swapped_ ? __builtin_bswap32(value) : value;
  }
  std::size_t size() const { return content_.size(); }
  bool swapped() const { return swapped_; }

 private:
  std::string_view content_;
  bool swapped_;
};

// The parts of a matrix between begin and end, so far as they are there: each must lie within, and
// there may be no more values than bytes.
bool parts_fit(const Numbers& numbers, std::size_t begin, std::size_t end, int depth = 0) {
  if (depth > kDeepest) return false;
  bool sparse = false;
  std::size_t part = 0;
  for (std::size_t at = begin; at + kTag <= std::min(end, numbers.size()); ++part) {
    const std::uint32_t type = numbers.at(at), length = numbers.at(at + 4);
    if (part == 0) sparse = (numbers.at(at + kTag) & 0xFF) == kSparse;
    if (type > 0xFFFF) {  // a short one, all in eight bytes
      at += kTag;
      continue;
    }
    if (length > end - at - kTag) return false;
    if (part == 1 && !sparse) {
      if (length / 4 > kFirstParts / 8) return false;
      double values = 1.0;
      for (std::size_t i = 0; i < length / 4; ++i) values *= numbers.at(at + kTag + 4 * i);
      if (values > double(end - begin)) return false;
    }
    if (type == kMatrix && !parts_fit(numbers, at + kTag, at + kTag + length, depth + 1)) {
      return false;
    }
    at += kTag + (std::size_t(length) + 7) / 8 * 8;
  }
  return true;
}

// Up to `limit` bytes of what is packed; fewer if there are no more, or damage.
std::string unpacked(std::string_view packed, std::size_t limit) {
  std::string out(limit, '\0');
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(limit);
  inflate(&stream, Z_SYNC_FLUSH);
  out.resize(limit - stream.avail_out);
  inflateEnd(&stream);
  return out;
}

bool packed_fits(std::string_view packed, bool swapped) {
  std::string head = unpacked(packed, kFirstParts);
  const Numbers numbers(head, swapped);
  if (numbers.at(0) != kMatrix) return false;
  const std::size_t length = numbers.at(4);
  if (length > kDensest * packed.size()) return false;
  if ((numbers.at(2 * kTag) & 0xFF) >= kFirstNumeric) {
    return parts_fit(numbers, kTag, kTag + length);
  }
  if (length > kNestedLimit) return false;
  head = unpacked(packed, kTag + length);
  return head.size() == kTag + length && parts_fit({head, swapped}, kTag, kTag + length);
}

}  // namespace

bool mat_elements_fit(std::string_view content) {
  constexpr bool kLittle = std::endian::native == std::endian::little;
  const Numbers numbers(content, content.substr(126, 2) == (kLittle ? "MI" : "IM"));
  std::size_t at = kHeader;
  while (at + kTag <= content.size()) {
    const std::uint32_t type = numbers.at(at);
    const std::size_t bytes = numbers.at(at + 4), begin = at + kTag;
    if (bytes > content.size() - begin) return false;
    if (type == kMatrix && !parts_fit(numbers, begin, begin + bytes)) return false;
    if (type == kPacked && !packed_fits(content.substr(begin, bytes), numbers.swapped())) {
      return false;
    }
    at = begin + bytes;
  }
  return at == content.size() && at > kHeader;
}

}  // namespace magimu
