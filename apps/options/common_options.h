// SPDX-License-Identifier: BSD-3-Clause
// What every command that starts from recordings takes, and the reading of them.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/options/reading_options.h"
#include "calibration/model/model.h"
#include "factors/sensor_model.h"
#include "recording/data/recording.h"

namespace magimu::apps {

struct RecordingOptions : ReadingOptions {
  std::vector<std::string> recordings;
  std::vector<double> noise_densities;
  std::string noise_file;
  double gravity = kStandardGravity;
  std::string motion = "auto";
  int threads = 0;
  bool json = false, quiet = false;

  std::optional<NoiseDensities> noise() const;
  MotionModel motion_model() const;
};

// What is read wherever a recording is.
inline constexpr const char* kRecordingFormats =
    "CSV, logs of ROS, PX4 or ArduPilot, phone folders, zip, MATLAB, HDF5, numpy; - is standard\n"
    "input (text)";

// Adds the recordings, --noise, --gravity, --motion and the options of reading_options.h. `options`
// must outlive `cmd`.
void add_recording_options(CLI::App& cmd, RecordingOptions& options);
// Adds only --noise, --gravity and --motion.
void add_model_options(CLI::App& cmd, RecordingOptions& options);
// --threads, --json (what it prints instead of text), -q.
void add_output_options(CLI::App& cmd, RecordingOptions& options, const std::string& json_prints);

// Reads all recordings, by read_with().
std::vector<Recording> read_recordings(const RecordingOptions& options);
// The words of the command line, the last first, as CLI11 takes them. `--noise NOISE.json` becomes
// --noise-file, since --noise takes three numbers; `--page` without a port --page-here, so that it
// does not take the source for one.
std::vector<std::string> words_of(int argc, char** argv);

std::vector<const Recording*> pointers(const std::vector<Recording>& recordings);

}  // namespace magimu::apps
