// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/device_readings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "archive/inventory/file_names.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

struct SplitPath {
  Names folders;
  std::string file, stem;
};

// common_folder: the innermost folder that all are in, if its name is more than a date or number.
std::vector<SplitPath> split_paths(const Names& shown, std::string& common_folder) {
  std::vector<SplitPath> out;
  for (const std::string& text : shown) {
    const fs::path path(text);
    SplitPath p{{}, path.filename().string(), path.stem().string()};
    for (const fs::path& part : path.parent_path()) p.folders.push_back(part.string());
    out.push_back(std::move(p));
  }
  // Folders that all of them are in tell nothing apart.
  const auto common = [&] {
    return !out.empty() && std::ranges::all_of(out, [&](const SplitPath& p) {
      return !p.folders.empty() && p.folders.front() == out.front().folders.front();
    });
  };
  while (common()) {
    const std::string name = out.front().folders.front();
    if (!words_of_name(name).empty()) common_folder = name;
    for (SplitPath& p : out) p.folders.erase(p.folders.begin());
  }
  return out;
}

template <class Name>
Names names_by(const std::vector<SplitPath>& paths, const Name& name, const std::string& whole) {
  Names out;
  for (const SplitPath& p : paths) {
    out.push_back(name(p));
    if (out.back().empty()) out.back() = whole;
  }
  return out;
}

std::size_t distinct(const Names& names) {
  return std::set<std::string>(names.begin(), names.end()).size();
}

// Has some device several recordings, and is there more than one?
bool shares(const Names& names) { return distinct(names) < names.size(); }

// A folder a session: each file name occurs in several folders, the files' names differ by more
// than a number, and the folders' by no more than a number or a date.
bool folders_are_sessions(const std::vector<SplitPath>& paths) {
  std::map<std::string, std::set<Names>> folders;  // of each file name
  std::set<std::string> files, first;
  for (const SplitPath& p : paths) {
    if (p.folders.empty()) return false;
    folders[p.file].insert(p.folders);
    files.insert(words_without_digits(p.stem));
    first.insert(words_without_digits(p.folders.front()));
  }
  return files.size() > 1 && first.size() == 1 &&
         std::ranges::all_of(folders, [](const auto& f) { return f.second.size() > 1; });
}

}  // namespace

bool same_groups(const Names& a, const Names& b) {
  std::map<std::string, std::string> to_b, to_a;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (to_b.emplace(a[i], b[i]).first->second != b[i]) return false;
    if (to_a.emplace(b[i], a[i]).first->second != a[i]) return false;
  }
  return true;
}

std::vector<DeviceReading> device_readings(const Names& shown, const std::string& archive) {
  std::string common_folder;
  const std::vector<SplitPath> paths = split_paths(shown, common_folder);
  const std::string whole = common_folder.empty() ? archive : common_folder;
  std::size_t deepest = 0;
  bool nested = !paths.empty();
  for (const SplitPath& p : paths) {
    deepest = std::max(deepest, p.folders.size());
    nested = nested && !p.folders.empty();
  }
  const auto words = [](const SplitPath& p) { return words_of_name(p.stem); };
  const auto folder_or_words = [&](std::size_t level) {
    return names_by(
        paths,
        [&](const SplitPath& p) {
          return p.folders.empty() ? words(p) : p.folders[std::min(level, p.folders.size() - 1)];
        },
        whole);
  };
  // "2024-01-10_flight7": a number at the end counts recordings, unless some have it in common.
  const Names by_words = names_by(paths, words, whole);
  const Names by_letters = names_by(
      paths, [](const SplitPath& p) { return words_without_digits(p.stem); }, whole);
  DeviceReading file{"the file's name without date and number is the device", by_words};
  DeviceReading letters{"the file's name without date and numbers is the device", by_letters};
  if (!shares(by_words)) std::swap(file, letters);

  std::vector<DeviceReading> out;
  const auto add = [&](const DeviceReading& reading) {
    for (const DeviceReading& r : out) {
      if (same_groups(r.device, reading.device)) return;
    }
    out.push_back(reading);
  };
  const auto add_folders = [&](bool that_tell) {
    for (std::size_t level = 0; level < deepest; ++level) {
      const Names names = folder_or_words(level);
      // Dates and numbers are no names of devices.
      const bool tells = std::ranges::none_of(paths, [&](const SplitPath& p) {
        return !p.folders.empty() &&
               words_of_name(p.folders[std::min(level, p.folders.size() - 1)]).empty();
      });
      if (tells != that_tell || distinct(names) < 2) continue;
      add({level == 0 ? "each first folder is a device"
                      : fmt::format("each folder at depth {} is a device", level + 1),
           names});
    }
  };
  if (nested && folders_are_sessions(paths)) {
    add(
        {"each file name occurs in several folders, so that a folder is a session and the file's "
         "name the device",
         by_words});
  }
  add_folders(true);
  if (!common_folder.empty() && !shares(by_words)) {
    add({"the folder that all are in is the device", Names(paths.size(), whole)});
  }
  add(file);
  if (deepest > 0) {
    add({"each folder is a device", names_by(
                                        paths,
                                        [&](const SplitPath& p) {
                                          return p.folders.empty()
                                                     ? words(p)
                                                     : fmt::format("{}", fmt::join(p.folders, "/"));
                                        },
                                        whole)});
  }
  add(letters);
  add_folders(false);
  add({"all are of one device", Names(paths.size(), whole)});
  return out;
}

}  // namespace magimu
