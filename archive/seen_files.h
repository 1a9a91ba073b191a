// SPDX-License-Identifier: BSD-3-Clause
// Hashes of files that were read before, by path, size and time of change, so that a second run
// over a thousand recordings need not read them again. A file that was changed less than two
// seconds before it was hashed is not remembered: it could change again within the clock's tick.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace magimu {

class SeenFiles {
 public:
  // What all files of that folder say; none is not an error.
  explicit SeenFiles(const std::string& folder);
  // content_hash(), remembered.
  std::string hash(const std::string& path);
  // Writes what was new, in a file of this name.
  void save(const std::string& name) const;

 private:
  struct Seen {
    std::int64_t size = 0, changed_ns = 0;
    std::uint64_t inode = 0;
    std::string hash;
    bool operator==(const Seen&) const = default;
  };
  std::string folder_;
  std::map<std::string, Seen> seen_;
  bool new_ = false;
};

}  // namespace magimu
