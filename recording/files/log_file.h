// SPDX-License-Identifier: BSD-3-Clause
// A large file from its beginning to its end, a piece in memory at a time, and numbers out of
// bytes: every access is held against the bytes that are there.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace magimu {

class LogFile {
 public:
  explicit LogFile(const std::string& path);  // InputError if it cannot be opened
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  std::uint64_t size() const { return size_; }
  // So many bytes, valid until the next call; fewer, none as a rule, where the file ends before.
  std::string_view at(std::uint64_t offset, std::uint64_t bytes);

 private:
  int fd_;
  std::uint64_t size_ = 0, begin_ = 0;
  std::vector<char> buffer_;
  std::size_t filled_ = 0;
};

// A number at the beginning of `bytes`; 0 where there are too few.
template <class T>
T bytes_as(std::string_view bytes, std::size_t offset, bool swapped = false) {
  T value{};
  if (bytes.size() < sizeof(T) || offset > bytes.size() - sizeof(T)) return value;
  char raw[sizeof(T)];
  std::memcpy(raw, bytes.data() + offset, sizeof(T));
  if (swapped) {
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
  }
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

}  // namespace magimu
