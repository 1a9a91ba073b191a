// SPDX-License-Identifier: BSD-3-Clause
#include "apps/common_options.h"

#include <fmt/format.h>

#include "recording/read.h"

namespace magimu::apps {

std::optional<NoiseDensities> RecordingOptions::noise() const {
  if (noise_densities.empty()) return std::nullopt;
  return NoiseDensities{noise_densities[0], noise_densities[1], noise_densities[2]};
}

MotionModel RecordingOptions::motion_model() const {
  if (motion == "rotation") return MotionModel::kRotation;
  if (motion == "hand_held") return MotionModel::kHandHeld;
  return MotionModel::kAuto;
}

void add_recording_options(CLI::App& cmd, RecordingOptions& options) {
  cmd.add_option("recordings", options.recordings, "CSV, or HDF5 or MATLAB files of the BROAD set")
      ->required()
      ->type_name("REC");
  add_model_options(cmd, options);
  cmd.add_option("--gyro-interval", options.gyro_interval,
                 "a gyroscope sample is the mean rate over the interval that begins at its time\n"
                 "(forward), has it in the middle (centred) or ends there (backward)")
      ->capture_default_str()
      ->check(CLI::IsMember({"forward", "centred", "backward"}));
}

void add_model_options(CLI::App& cmd, RecordingOptions& options) {
  cmd.add_option("--noise", options.noise_densities,
                 "noise densities per sqrt(Hz): m/s^2 rad/s uT (default: estimated)")
      ->expected(3)
      ->check(CLI::PositiveNumber)
      ->type_name("ACC GYR MAG");
  cmd.add_option("--gravity", options.gravity, "local gravity, m/s^2")
      ->capture_default_str()
      ->check(CLI::Range(9.7, 9.9))
      ->type_name("G");
  cmd.add_option("--motion", options.motion,
                 "rotation: the sensor only turned; hand_held: a hand moved it within its reach;\n"
                 "auto: decided from the data")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "rotation", "hand_held"}));
}

void add_output_options(CLI::App& cmd, RecordingOptions& options, const std::string& json_prints) {
  cmd.add_option("--threads", options.threads, "use at most so many threads (0: all)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd.add_flag("--json", options.json, json_prints);
  cmd.add_flag("-q,--quiet", options.quiet, "print nothing but errors");
}

std::vector<Recording> read_recordings(const RecordingOptions& options) {
  std::vector<Recording> out;
  for (const std::string& path : options.recordings) {
    out.push_back(read_recording(path));
    if (options.gyro_interval == "centred") {
      convert_gyro_interval(out.back(), GyroInterval::kCentred);
    } else if (options.gyro_interval == "backward") {
      convert_gyro_interval(out.back(), GyroInterval::kBackward);
    }
    if (options.quiet) continue;
    for (const std::string& note : out.back().notes) {
      fmt::print(stderr, "{}: {}\n", out.back().name, note);
    }
  }
  return out;
}

std::vector<const Recording*> pointers(const std::vector<Recording>& recordings) {
  std::vector<const Recording*> out;
  for (const Recording& r : recordings) out.push_back(&r);
  return out;
}

}  // namespace magimu::apps
