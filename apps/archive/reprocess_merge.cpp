// SPDX-License-Identifier: BSD-3-Clause
#include "apps/archive/reprocess_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/archive/reprocess_pages.h"
#include "apps/options/stop_signals.h"
#include "apps/say/progress.h"
#include "archive/result_file.h"
#include "archive/second_pass.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"
#include "recording/files/read_file.h"

namespace magimu::apps {
namespace {

namespace fs = std::filesystem;

// A device's name as a file's: what a file system might not bear is replaced, and a number tells
// apart what that makes alike.
std::vector<std::string> file_names(const std::vector<std::string>& devices) {
  std::vector<std::string> out;
  std::set<std::string> taken;
  for (const std::string& device : devices) {
    std::string plain;
    for (const char c : device.substr(0, 100)) {
      const bool safe = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                        (c >= 'A' && c <= 'Z') || c == '-' || c == '_' ||
                        (c == '.' && !plain.empty());
      plain += safe ? c : '_';
    }
    if (plain.empty()) plain = "device";
    std::string name = plain;
    for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}-{}", plain, i);
    out.push_back(name);
  }
  return out;
}

std::string joined_words(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

// Files of an earlier run about devices that are there no more. What is no such file stays.
void remove_other_devices(const fs::path& folder, const std::vector<std::string>& files) {
  const std::set<std::string> kept(files.begin(), files.end());
  std::vector<fs::path> old;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != ".json" || kept.contains(it->path().stem().string())) continue;
    const auto json =
        nlohmann::json::parse(read_file(it->path().string()), nullptr, /*allow_exceptions=*/false);
    if (json.is_object() && json.contains("device") && json.contains("history")) {
      old.push_back(it->path());
    }
  }
  for (fs::path path : old) {
    fs::remove(path, error);
    fs::remove(path.replace_extension(".html"), error);
  }
}

}  // namespace

std::vector<DeviceRecording> recordings_of(const std::vector<FleetRecording*>& rows,
                                           const std::string& folder,
                                           std::vector<FleetRecording*>& calibrated) {
  std::vector<DeviceRecording> out;
  std::set<std::string> seen;
  for (FleetRecording* row : rows) {
    if (row->result.empty()) continue;
    const std::string path = (fs::path(folder) / "results" / (row->result + ".json")).string();
    std::error_code error;
    if (!fs::exists(path, error)) {
      if (row->status.empty()) {
        row->status = "unfinished";
        row->reason = "it has not been processed yet, or its process was killed";
        row->remedy = "run magimu reprocess again: it goes on where it was";
      }
      continue;
    }
    const ArchiveResult result = read_result(path);
    row->status = to_string(result.status);
    row->reason = result.reason;
    row->remedy = result.remedy;
    row->found = joined_words(result.found);
    row->duration_s = result.duration_s;
    if (result.status != ResultStatus::kCalibrated) continue;
    if (!seen.insert(row->result).second) {
      row->status = "duplicate";
      row->reason =
          "another recording of this device has the same bytes and options: it counts once";
      row->remedy = "leave one of them out";
      continue;
    }
    DeviceRecording recording = device_recording(result, path);
    recording.name = row->result;
    recording.shown = row->path;
    recording.place = row->place;
    recording.date = row->date;
    if (fs::exists(row->at_device, error)) {
      const ArchiveResult second = read_result(row->at_device);
      if (second.status == ResultStatus::kCalibrated) {
        take_second_pass(recording, device_recording(second, row->at_device));
      }
    }
    out.push_back(std::move(recording));
    calibrated.push_back(row);
  }
  return out;
}

std::optional<std::vector<FleetDevice>> merge_archive(std::vector<FleetRecording>& rows,
                                                      const std::string& folder,
                                                      const std::string& devices_by, bool quiet) {
  std::map<std::string, std::vector<FleetRecording*>> by_device;
  std::map<std::string, std::set<std::string>> devices_of_result;
  for (FleetRecording& row : rows) {
    by_device[row.device].push_back(&row);
    if (!row.result.empty()) devices_of_result[row.result].insert(row.device);
  }
  std::vector<std::string> names;
  for (const auto& [name, own] : by_device) names.push_back(name);
  const std::vector<std::string> files = file_names(names);
  const fs::path devices_folder = fs::path(folder) / "devices";
  fs::create_directories(devices_folder);
  std::vector<FleetDevice> devices;
  std::vector<std::string> pages;
  ProgressBar bar(!quiet);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (stop_requested()) return std::nullopt;
    bar("device " + names[i], double(i) / double(names.size()));
    std::vector<FleetRecording*> calibrated;
    std::vector<DeviceRecording> recordings =
        recordings_of(by_device[names[i]], folder, calibrated);
    const Device device = make_device(names[i], std::move(recordings));
    // Rows in the device's own order.
    std::vector<FleetRecording*> in_order;
    for (const DeviceRecording& r : device.recordings) {
      in_order.push_back(*std::ranges::find_if(
          calibrated, [&](const FleetRecording* row) { return row->result == r.name; }));
    }
    FleetDevice summary = fleet_device(device, in_order);
    for (FleetRecording* row : in_order) {
      const std::set<std::string>& of = devices_of_result[row->result];
      if (of.size() < 2) continue;
      const std::string& other = *of.begin() == names[i] ? *std::next(of.begin()) : *of.begin();
      row->reason += fmt::format("{}The same bytes stand under the device {}, too.",
                                 row->reason.empty() ? "" : " ", other);
    }
    summary.recordings = by_device[names[i]].size();
    std::vector<const FleetRecording*> all(in_order.begin(), in_order.end());
    for (const FleetRecording* row : by_device[names[i]]) {
      if (std::ranges::find(all, row) == all.end()) all.push_back(row);
    }
    pages.push_back("devices/" + files[i] + ".html");
    write_atomically((devices_folder / (files[i] + ".json")).string(), device_json(device));
    write_atomically((fs::path(folder) / pages.back()).string(), device_page(device, summary, all));
    devices.push_back(std::move(summary));
  }
  remove_other_devices(devices_folder, files);
  const auto path = [&](const char* name) { return (fs::path(folder) / name).string(); };
  write_atomically(path("recordings.csv"), recordings_csv(rows));
  write_atomically(path("devices.csv"), devices_csv(devices));
  write_atomically(path("changes.csv"), changes_csv(devices));
  write_atomically(path("archive.sqlite"), fleet_database(rows, devices));
  write_atomically(path("index.html"), fleet_page(rows, devices, pages, devices_by));
  return devices;
}

}  // namespace magimu::apps
