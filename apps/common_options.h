// SPDX-License-Identifier: BSD-3-Clause
// What every command that starts from recordings takes, and the reading of them.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/model.h"
#include "factors/sensor_model.h"
#include "recording/recording.h"

namespace magimu::apps {

struct RecordingOptions {
  std::vector<std::string> recordings;
  std::vector<double> noise_densities;
  double gravity = kStandardGravity;
  std::string motion = "auto", gyro_interval = "forward";
  int threads = 0;
  bool json = false, quiet = false;

  std::optional<NoiseDensities> noise() const;
  MotionModel motion_model() const;
};

// recordings, --noise, --gravity, --motion, --gyro-interval; options must live as long as cmd.
void add_recording_options(CLI::App& cmd, RecordingOptions& options);
// Of these --noise, --gravity and --motion.
void add_model_options(CLI::App& cmd, RecordingOptions& options);
// --threads, --json (what it prints instead of text), -q.
void add_output_options(CLI::App& cmd, RecordingOptions& options, const std::string& json_prints);

// The recordings, with gyroscope intervals as the library has them; what the reader noticed goes to
// standard error unless quiet.
std::vector<Recording> read_recordings(const RecordingOptions& options);
std::vector<const Recording*> pointers(const std::vector<Recording>& recordings);

}  // namespace magimu::apps
