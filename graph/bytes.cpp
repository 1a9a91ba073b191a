// SPDX-License-Identifier: BSD-3-Clause
#include "graph/bytes.h"

#include <algorithm>
#include <cstring>

namespace magimu {
namespace {

constexpr std::size_t kBlock = std::size_t(1) << 16;          // bytes
constexpr std::uint64_t kMostBytes = std::uint64_t(1) << 30;  // of one sequence

}  // namespace

void Checksum::add(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  for (; size > 0;) {
    const std::size_t taken = std::min(size, sizeof(std::uint64_t));
    std::uint64_t word = 0;
    std::memcpy(&word, from, taken);
    mix(word + (taken << 56));
    from += taken;
    size -= taken;
  }
}

void Checksum::mix(std::uint64_t word) {
  sum_ = (sum_ ^ word) * 0x9e3779b97f4a7c15U;
  sum_ ^= sum_ >> 29;
}

void ByteWriter::raw(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0) {
    const std::size_t taken = std::min(size, kBlock - block_.size());
    block_.append(from, taken);
    from += taken;
    size -= taken;
    if (block_.size() == kBlock) write_block();
  }
}

void ByteWriter::write_block() {
  sum_.add(block_.data(), block_.size());
  out_.write(block_.data(), std::streamsize(block_.size()));
  block_.clear();
}

bool ByteWriter::finish() {
  write_block();
  const std::uint64_t sum = sum_.value();
  out_.write(reinterpret_cast<const char*>(&sum), sizeof sum);
  return bool(out_.flush());
}

bool is_whole(std::istream& in) {
  const auto begin = in.tellg();
  const auto end = in.seekg(0, std::ios::end).tellg();
  in.seekg(begin);
  std::uint64_t sum = 0;
  if (!in || end - begin < std::streamoff(sizeof sum)) return false;
  auto left = std::size_t(end - begin) - sizeof sum;
  Checksum found;
  std::string block;
  while (left > 0) {
    block.resize(std::min(left, kBlock));
    if (!in.read(block.data(), std::streamsize(block.size()))) return false;
    found.add(block.data(), block.size());
    left -= block.size();
  }
  in.read(reinterpret_cast<char*>(&sum), sizeof sum);
  return bool(in) && sum == found.value() && bool(in.seekg(begin));
}

std::size_t ByteReader::size(std::size_t each) {
  const auto n = get<std::uint64_t>();
  if (n > kMostBytes / each) throw std::runtime_error("a size that cannot be right");
  return std::size_t(n);
}

void ByteReader::raw(void* data, std::size_t size) {
  if (!in_.read(static_cast<char*>(data), std::streamsize(size))) {
    throw std::runtime_error("the end comes too soon");
  }
}

}  // namespace magimu
