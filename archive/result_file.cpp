// SPDX-License-Identifier: BSD-3-Clause
#include "archive/result_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "archive/inventory/sha256.h"
#include "calibration/result/calibration_json.h"
#include "recording/data/error.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

using ResultJson = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kFormat = "magimu-archive-result/1";
constexpr const char* kStatusNames[] = {"calibrated", "refused",   "no_fit",
                                        "too_long",   "too_large", "crashed"};

[[noreturn]] void refuse_result(const std::string& path, const std::string& what) {
  throw InputError(path, 0, 0, "this is no result of magimu reprocess: " + what,
                   "remove the file and run magimu reprocess again");
}

}  // namespace

std::string to_string(ResultStatus status) { return kStatusNames[int(status)]; }

std::string result_json(const std::string& name, const ArchiveResult& r, const Provenance& p) {
  ResultJson out;
  out["format"] = kFormat;
  out["name"] = name;
  out["status"] = to_string(r.status);
  out["reason"] = r.reason;
  out["remedy"] = r.remedy;
  out["found"] = r.found;
  out["duration_s"] = r.duration_s;
  out["calibration"] = r.calibration;
  out["summary"] = r.summary;
  if (r.status == ResultStatus::kTooLong) out["limit_s"] = r.limit_s;
  if (r.status == ResultStatus::kTooLarge) out["limit_megabytes"] = r.limit_megabytes;
  out["provenance"] = {
      {"version", p.version}, {"path", p.path}, {"options", p.options}, {"date", p.date}};
  return out.dump(1, ' ', false, ResultJson::error_handler_t::replace) + "\n";
}

ArchiveResult read_result(const std::string& path) {
  const ResultJson json = ResultJson::parse(read_file(path), nullptr, false);
  if (!json.is_object()) refuse_result(path, "it is no JSON object");
  if (json.value("format", "") != kFormat) refuse_result(path, "its format is another one");
  try {
    ArchiveResult out;
    const auto status = json.at("status").get<std::string>();
    const auto* found = std::ranges::find(kStatusNames, status);
    if (found == std::end(kStatusNames)) refuse_result(path, "its status is " + status);
    out.status = ResultStatus(found - kStatusNames);
    out.reason = json.at("reason").get<std::string>();
    out.remedy = json.at("remedy").get<std::string>();
    out.found = json.at("found").get<std::vector<std::string>>();
    out.duration_s = json.at("duration_s").get<double>();
    out.calibration = json.at("calibration");
    out.summary = json.at("summary");
    out.limit_s = json.value("limit_s", -1.0);
    out.limit_megabytes = json.value("limit_megabytes", -1.0);
    return out;
  } catch (const nlohmann::json::exception& error) {
    refuse_result(path, error.what());
  }
}

bool stopped_at_less(const std::string& path, double limit_s, double limit_megabytes) {
  // The status is among the first lines; a thousand calibrations need not be read for it.
  std::string head(1000, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), std::streamsize(head.size()));
  if (head.find("\"status\": \"too_") == std::string::npos) return false;
  const ArchiveResult result = read_result(path);
  // Without a limit then, there is no larger one; below 0: nobody knows which there was.
  const auto larger = [](double now, double then) {
    return then < 0.0 || (then > 0.0 && (now <= 0.0 || now > then));
  };
  if (result.status == ResultStatus::kTooLong) return larger(limit_s, result.limit_s);
  if (result.status != ResultStatus::kTooLarge) return false;
  return larger(limit_megabytes, result.limit_megabytes);
}

DeviceRecording device_recording(const ArchiveResult& result, const std::string& file) {
  DeviceRecording out;
  out.calibration = calibration_from_json(result.calibration, file);
  if (!result.summary.is_null()) out.condensed = condensed_from_json(result.summary, file);
  for (const ResultJson& check : result.calibration.value("checks", ResultJson::array())) {
    if (check.value("name", "") != "halves" || check.value("status", "ok") == "ok") continue;
    out.widened = std::max(1.0, check.value("value", 1.0));
  }
  return out;
}

std::string content_hash(const std::string& path) {
  Sha256 hash;
  std::error_code error;
  // Nobody may ever write into a pipe: whoever opens it waits for that.
  if (is_pipe_or_device(path)) {
    throw InputError(path, 0, 0, "this is a pipe or a device, which can be read once only",
                     "give a file");
  }
  if (!fs::is_directory(path, error)) {
    read_file_in_pieces(path, [&](std::string_view piece, std::size_t) { hash.add(piece); });
    return hash.hex();
  }
  std::vector<fs::path> files;
  for (fs::recursive_directory_iterator it(path, error), end; !error && it != end;
       it.increment(error)) {
    if (it->is_regular_file(error)) files.push_back(it->path());
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    // Names and contents cannot run into one another: each has a hash of its own.
    Sha256 name;
    name.add(file.lexically_relative(path).string());
    hash.add(name.hex());
    hash.add(content_hash(file.string()));
  }
  return hash.hex();
}

std::string result_name(const std::string& content, const std::vector<std::string>& options,
                        const std::string& version) {
  Sha256 hash;
  hash.add(content);
  for (const std::string& word : options) {
    hash.add(std::string_view("\n", 1));
    hash.add(word);
  }
  hash.add(std::string_view("\0", 1));
  hash.add(version);
  return hash.hex().substr(0, 40);
}

}  // namespace magimu
