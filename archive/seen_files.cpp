// SPDX-License-Identifier: BSD-3-Clause
#include "archive/seen_files.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "archive/result_file.h"
#include "recording/files/atomic_file.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSettled_ns = 2'000'000'000;

}  // namespace

SeenFiles::SeenFiles(const std::string& folder) : folder_(folder) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::ifstream file(it->path());
    for (std::string line; std::getline(file, line);) {
      std::istringstream fields(line);
      Seen seen;
      std::string path;
      if (!(fields >> seen.hash >> seen.size >> seen.changed_ns >> seen.inode)) continue;
      fields.get();
      if (std::getline(fields, path) && seen.hash.size() == 64) seen_[path] = seen;
    }
  }
}

std::string SeenFiles::hash(const std::string& path) {
  struct stat status {};
  const std::string key = fs::weakly_canonical(path).string();
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) ||
      key.find('\n') != std::string::npos) {
    return content_hash(path);
  }
  Seen now{status.st_size,
           std::int64_t(status.st_ctim.tv_sec) * 1'000'000'000 + status.st_ctim.tv_nsec,
           status.st_ino, ""};
  if (const auto it = seen_.find(key); it != seen_.end()) {
    now.hash = it->second.hash;
    if (now == it->second) return now.hash;
  }
  timespec clock{};
  ::clock_gettime(CLOCK_REALTIME, &clock);
  const std::int64_t begin = std::int64_t(clock.tv_sec) * 1'000'000'000 + clock.tv_nsec;
  now.hash = content_hash(path);
  if (begin - now.changed_ns > kSettled_ns) {
    seen_[key] = now;
    new_ = true;
  }
  return now.hash;
}

void SeenFiles::save(const std::string& name) const {
  if (!new_) return;
  std::string text;
  for (const auto& [path, seen] : seen_) {
    text +=
        fmt::format("{} {} {} {} {}\n", seen.hash, seen.size, seen.changed_ns, seen.inode, path);
  }
  fs::create_directories(folder_);
  write_atomically((fs::path(folder_) / name).string(), text);
}

}  // namespace magimu
