// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/found_files.h"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <set>

#include "recording/data/error.h"
#include "recording/files/read_file.h"
#include "recording/several_files.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;

std::string true_path(const fs::path& path) {
  std::error_code error;
  const fs::path out = fs::canonical(path, error);
  return error ? path.lexically_normal().string() : out.string();
}

class Search {
 public:
  explicit Search(const std::string& folder) : folders_{folder}, root_(true_path(folder)) {
    std::error_code error;
    const fs::directory_iterator opened(folder, error);
    if (error) {
      throw InputError(folder, 0, 0, "the folder cannot be read: " + error.message(),
                       "look at its permissions");
    }
    while (!folders_.empty() || !links_.empty()) {
      std::deque<fs::path>& next = folders_.empty() ? links_ : folders_;
      const fs::path path = next.front();
      next.pop_front();
      if (&next == &links_) {
        look_at(path);
      } else {
        search(path);
      }
    }
    std::ranges::sort(found_);
  }
  std::vector<std::string> found() && { return std::move(found_); }

 private:
  void search(const fs::path& folder) {
    const std::string path = true_path(folder);
    // A link to a folder around this one leads out of the archive, and around.
    const bool around = path != root_ && (root_ + "/").starts_with(path == "/" ? path : path + "/");
    if (around || !searched_.insert(path).second) return;
    std::vector<fs::path> entries;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      entries.push_back(it->path());
    }
    std::ranges::sort(entries);  // which of several links counts must not depend on the disk
    for (const fs::path& entry : entries) {
      if (entry.filename().string().starts_with(".")) continue;
      if (fs::is_symlink(entry, error)) {
        links_.push_back(entry);
      } else {
        look_at(entry);
      }
    }
  }

  void look_at(const fs::path& path) {
    std::error_code error;
    const bool folder = fs::is_directory(path, error);
    if (folder && !is_folder_of_sensors(path.string())) {
      if (!is_reprocess_output(path.string())) folders_.push_back(path);
    } else if (is_pipe_or_device(path.string())) {
      return;  // a pipe, a device: who opens it waits for its writer
    } else if (seen_.insert(true_path(path)).second && !searched_.contains(true_path(path))) {
      found_.push_back(path.string());
    }
  }

  std::deque<fs::path> folders_, links_;
  std::string root_;
  std::set<std::string> searched_, seen_;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> files_below(const std::string& folder) { return Search(folder).found(); }

bool is_reprocess_output(const std::string& folder) {
  std::error_code error;
  const fs::path results = fs::path(folder) / "results";
  if (!fs::is_directory(results, error)) return false;
  for (fs::directory_iterator it(results, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().stem().string();  // result_name()
    if (it->path().extension() == ".json" && name.size() == 40 &&
        name.find_first_not_of("0123456789abcdef") == std::string::npos) {
      return true;
    }
  }
  return fs::is_directory(fs::path(folder) / "seen", error) &&
         fs::is_regular_file(fs::path(folder) / "merged", error);
}

}  // namespace magimu
