// SPDX-License-Identifier: BSD-3-Clause
// What has been unpacked, on disk and not in memory, in a file without a name that vanishes with
// its owner: readers that want a path get one.
#pragma once

#include <string>
#include <string_view>

namespace magimu {

class TemporaryFile {
 public:
  TemporaryFile();  // InputError where there is no room for one
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  TemporaryFile(TemporaryFile&& other) noexcept;

  void append(std::string_view bytes);
  std::string path() const;

 private:
  int fd_;
};

}  // namespace magimu
