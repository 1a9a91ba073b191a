// SPDX-License-Identifier: BSD-3-Clause
// The file of a journal's bytes: opened by one process at a time, appended to, and on the disk when
// append() returns. Internal to recording/.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace magimu {

class JournalFile {
 public:
  // Created if it is not there. InputError if it cannot be opened, or another process has it.
  explicit JournalFile(std::string path);
  ~JournalFile();
  JournalFile(const JournalFile&) = delete;
  JournalFile& operator=(const JournalFile&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size() const;
  // At least one byte; at most `bytes`, and at most a block.
  std::string read(std::uint64_t at, std::uint64_t bytes) const;
  // `end` is the file's size, which the caller keeps.
  void append(std::uint64_t end, std::string_view bytes) const;
  void cut(std::uint64_t size) const;

 private:
  [[noreturn]] void fail(const std::string& remedy) const;

  std::string path_;
  int fd_ = -1;
};

}  // namespace magimu
