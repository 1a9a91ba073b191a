// SPDX-License-Identifier: BSD-3-Clause
#include "apps/archive/reprocess_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "archive/result_file.h"
#include "archive/same_device.h"

namespace magimu::apps {
namespace {

namespace fs = std::filesystem;

struct MarkedRows {
  std::vector<std::size_t> rows;
  std::vector<DeviceMark> marks;
};

// Of rows whose device is guessed and which have a calibration to rely on; copies count once.
MarkedRows marked_rows(const std::vector<ManifestEntry>& entries,
                       const std::vector<FleetRecording>& rows, const std::string& folder) {
  MarkedRows out;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string& name = rows[i].result;
    if (!entries[i].device_guessed || name.empty() || !seen.insert(name).second) continue;
    const std::string path = (fs::path(folder) / "results" / (name + ".json")).string();
    std::error_code error;
    if (!fs::exists(path, error)) continue;
    const ArchiveResult result = read_result(path);
    if (result.status != ResultStatus::kCalibrated) continue;
    std::optional<DeviceMark> mark = mark_of(device_recording(result, path).calibration);
    if (!mark) continue;
    out.rows.push_back(i);
    out.marks.push_back(std::move(*mark));
  }
  return out;
}

std::vector<std::size_t> numbers_of(const std::vector<std::string>& names) {
  std::map<std::string, std::size_t> number;
  std::vector<std::size_t> out;
  for (const std::string& name : names)
    out.push_back(number.emplace(name, number.size()).first->second);
  return out;
}

// What the recordings say of one reading: of the distortions, and of that of the other families
// which says most.
struct ReadingEvidence {
  double distortion = 0.0, other = 0.0;
};

ReadingEvidence evidence_of(const DeviceReading& reading, const MarkedRows& marked) {
  std::vector<std::string> names;
  for (const std::size_t i : marked.rows) names.push_back(reading.device[i]);
  const std::vector<std::size_t> group = numbers_of(names);
  ReadingEvidence out{log_factor_of_groups(marked.marks, group, DeviceMark::kDistortion), 0.0};
  for (const auto family :
       {DeviceMark::kHardIron, DeviceMark::kGyroscopeBias, DeviceMark::kAccelerometerBias}) {
    out.other = std::max(out.other, log_factor_of_groups(marked.marks, group, family));
  }
  return out;
}

// Distortions and biases both: a device whose hard iron has changed once stays one device.
double margin(const ReadingEvidence& a, const ReadingEvidence& b) {
  return std::min(a.distortion - b.distortion, a.other - b.other);
}

}  // namespace

std::string choose_devices(const std::vector<ManifestEntry>& entries,
                           const std::vector<DeviceReading>& readings, const std::string& folder,
                           std::vector<FleetRecording>& rows) {
  if (readings.empty() || std::ranges::none_of(entries, &ManifestEntry::device_guessed)) return "";
  const MarkedRows marked = marked_rows(entries, rows, folder);
  std::size_t best = 0;
  std::string why;
  if (marked.rows.size() > 2) {
    const ReadingEvidence usual = evidence_of(readings.front(), marked);
    ReadingEvidence most = usual;
    for (std::size_t r = 1; r < readings.size(); ++r) {
      const ReadingEvidence now = evidence_of(readings[r], marked);
      if (margin(now, usual) < log_factor_that_decides() || margin(now, most) <= 0.0) continue;
      most = now;
      best = r;
    }
    if (best > 0) {
      why = fmt::format(
          ". The more usual reading ({}) would mix recordings whose distortions and biases differ "
          "by many standard deviations",
          readings.front().rule);
    } else if (margin(usual, {}) > log_factor_that_decides()) {
      why = ". The recordings' distortions and biases confirm it";
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (entries[i].device_guessed) rows[i].device = readings[best].device[i];
  }
  return fmt::format(
      "Devices are guessed from names: {}{}. If that is wrong, name them in a manifest (columns "
      "path and device).",
      readings[best].rule, why);
}

}  // namespace magimu::apps
