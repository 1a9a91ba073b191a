// SPDX-License-Identifier: BSD-3-Clause
// One recording's result as a file of the format "magimu-archive-result/1" (docs/reprocess.md).
// Its name comes from the bytes of the recording, the options and the program's version: the same
// work has the same name wherever it is done, and what has a file is done.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "archive/device.h"

namespace magimu {

// How a recording came out.
enum class ResultStatus {
  kCalibrated,  // there is a fit, whatever its verdict
  kRefused,     // it cannot be read, or holds no recording
  kNoFit,       // it is read, and permits no fit
  kTooLong,     // stopped at the limit of time
  kTooLarge,    // stopped at the limit of memory
  kCrashed,     // a defect of the program
};
std::string to_string(ResultStatus status);

struct ArchiveResult {
  ResultStatus status = ResultStatus::kRefused;
  std::string reason, remedy;      // of all but kCalibrated
  std::vector<std::string> found;  // options that the program found by itself, such as units
  double duration_s = 0.0;
  nlohmann::ordered_json calibration, summary;  // null where there is none
  // Limits that it was made under; 0: none, below: unknown. kTooLong and kTooLarge are tried again
  // with larger ones.
  double limit_s = 0.0, limit_megabytes = 0.0;
};

struct Provenance {
  std::string version, path, options, date;
};

std::string result_json(const std::string& name, const ArchiveResult& result,
                        const Provenance& provenance);
// InputError where it is not such a file.
ArchiveResult read_result(const std::string& path);

// Whether a run with these limits (0: none) may get further than the run that wrote this file: it
// ended at a limit that is larger now, or nobody knows at which. False where it came to its end.
bool stopped_at_less(const std::string& path, double limit_s, double limit_megabytes);

// What the device needs of it; status kCalibrated.
DeviceRecording device_recording(const ArchiveResult& result, const std::string& file);

// SHA-256 of a file's bytes, or of a folder's files with their names. InputError where it cannot be
// read.
std::string content_hash(const std::string& path);
// The result's name.
std::string result_name(const std::string& content, const std::vector<std::string>& options,
                        const std::string& version);

}  // namespace magimu
