// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/common_options.h"

#include <algorithm>
#include <charconv>

#include "apps/options/number_checks.h"
#include "apps/options/outputs.h"
#include "calibration/rest_noise/noise_at_rest.h"

namespace magimu::apps {

std::optional<NoiseDensities> RecordingOptions::noise() const {
  if (!noise_file.empty()) return read_noise(noise_file);
  if (noise_densities.empty()) return std::nullopt;
  return NoiseDensities{noise_densities[0], noise_densities[1], noise_densities[2]};
}

MotionModel RecordingOptions::motion_model() const {
  if (motion == "rotation") return MotionModel::kRotation;
  if (motion == "hand_held") return MotionModel::kHandHeld;
  if (motion == "travelling") return MotionModel::kTravelling;
  return MotionModel::kAuto;
}

void add_recording_options(CLI::App& cmd, RecordingOptions& options) {
  cmd.add_option("recordings", options.recordings, kRecordingFormats)
      ->required()
      ->transform(standard_input())
      ->type_name("REC");
  add_model_options(cmd, options);
  add_reading_options(cmd, options);
}

void add_model_options(CLI::App& cmd, RecordingOptions& options) {
  CLI::Option* densities =
      cmd.add_option("--noise", options.noise_densities,
                     "noise densities per sqrt(Hz): m/s^2 rad/s uT, or a file that `magimu allan`\n"
                     "wrote (default: estimated)")
          ->expected(3)
          ->check(positive_number())
          ->type_name("ACC GYR MAG|NOISE.json");
  cmd.add_option("--noise-file", options.noise_file)->group("")->excludes(densities);
  cmd.add_option("--gravity", options.gravity, "local gravity, m/s^2")
      ->capture_default_str()
      ->check(CLI::Range(9.7, 9.9))
      ->type_name("G");
  cmd.add_option("--motion", options.motion,
                 "rotation: the sensor only turned; hand_held: a hand moved it within its reach;\n"
                 "travelling: it walked, drove or flew; auto: decided from the data")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "rotation", "hand_held", "travelling"}));
}

void add_output_options(CLI::App& cmd, RecordingOptions& options, const std::string& json_prints) {
  cmd.add_option("--threads", options.threads, "use at most so many threads (0: all)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd.add_flag("--json", options.json, json_prints);
  cmd.add_flag("-q,--quiet", options.quiet, "print nothing but errors");
}

std::vector<Recording> read_recordings(const RecordingOptions& options) {
  return read_all_with(options.recordings, options, options.quiet);
}

std::vector<std::string> words_of(int argc, char** argv) {
  const auto is_number = [](const std::string& text) {
    double value = 0.0;
    const char* end = text.data() + text.size();
    return std::from_chars(text.data(), end, value).ptr == end;
  };
  // A port, or an address and a port; not a source such as tcp://host:5000 or rec.csv.
  const auto is_page = [&is_number](const std::string& text) {
    const std::size_t colon = text.rfind(':');
    const bool has_host = colon != std::string::npos && text.find('/') == std::string::npos;
    return is_number(has_host ? text.substr(colon + 1) : text);
  };
  std::vector<std::string> words;
  for (int i = argc - 1; i > 0; --i) {
    const std::string word = argv[i];
    const std::string next = words.empty() ? "" : words.back();
    if (word == "--noise" && !next.empty() && !is_number(next) && !next.starts_with("-")) {
      words.push_back("--noise-file");
    } else if (word == "--page" && (next.empty() || !is_page(next))) {
      words.push_back("--page-here");
    } else {
      words.push_back(word);
    }
  }
  return words;
}

std::vector<const Recording*> pointers(const std::vector<Recording>& recordings) {
  std::vector<const Recording*> out;
  for (const Recording& r : recordings) out.push_back(&r);
  return out;
}

}  // namespace magimu::apps
