// SPDX-License-Identifier: BSD-3-Clause
#include "apps/copies.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "archive/result_file.h"

namespace magimu::apps {

namespace fs = std::filesystem;

std::vector<GivenCopy> leave_out_copies(std::vector<std::string>& paths) {
  std::vector<GivenCopy> out;
  std::map<std::uintmax_t, std::size_t> sizes;  // a file's bytes, and how many files have as many
  const auto size_of = [](const std::string& path) {
    std::error_code error;
    const bool folder = fs::is_directory(path, error);
    if (!folder && !fs::is_regular_file(path, error)) return std::uintmax_t(0);  // a pipe
    return folder ? std::uintmax_t(1) : fs::file_size(path, error);
  };
  for (const std::string& path : paths) ++sizes[size_of(path)];
  std::map<std::string, std::string> first;  // of each content
  std::vector<std::string> kept;
  for (const std::string& path : paths) {
    const std::uintmax_t size = size_of(path);
    if (size == 0 || sizes[size] < 2) {
      kept.push_back(path);
      continue;
    }
    const auto [it, is_new] = first.emplace(content_hash(path), path);
    if (is_new) {
      kept.push_back(path);
    } else {
      out.push_back({path, it->second});
    }
  }
  paths = std::move(kept);
  return out;
}

void caution_of_copies(const std::vector<GivenCopy>& copies, std::vector<Recording>& recordings) {
  if (recordings.empty()) return;
  for (const GivenCopy& copy : copies) {
    const auto own = std::ranges::find(recordings, copy.of, &Recording::name);
    Recording& kept = own == recordings.end() ? recordings.front() : *own;
    kept.cautions.push_back(copy.path == copy.of
                                ? "it was given twice: it counts once"
                                : copy.path +
                                      " has the same bytes, and was left out: a copy is no "
                                      "second recording");
  }
}

}  // namespace magimu::apps
