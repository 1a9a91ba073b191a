// SPDX-License-Identifier: BSD-3-Clause
// `magimu allan REC -o NOISE.json`
#include <fmt/format.h>

#include "apps/allan_text.h"
#include "apps/commands.h"
#include "apps/options/common_options.h"
#include "apps/options/outputs.h"
#include "apps/say/progress.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

struct AllanArguments : RecordingOptions {
  std::string output, report;
};

int run(const AllanArguments& args) {
  check_outputs(args.recordings, {args.output, args.report});
  const std::vector<Recording> recordings = read_recordings(args);
  const Recording& recording = recordings.front();
  const MotionAtRest motion = motion_at_rest(recording);
  if (!motion.reason.empty()) {
    fmt::print(stderr, "magimu: {}: {}\n", recording.name, motion.reason);
    return kNoAnswer;
  }
  const RestNoise noise =
      with_bar(!args.quiet, "noise at rest", [&] { return noise_of(recording, motion.rest); });
  const std::string json = to_json(noise).dump(2) + "\n";
  if (!args.output.empty()) write_atomically(args.output, json);
  if (!args.report.empty()) write_atomically(args.report, allan_report(noise));
  if (args.json) {
    fmt::print("{}", json);
  } else if (!args.quiet) {
    fmt::print("{}", allan_table(noise));
  }
  return kDone;
}

}  // namespace

void add_allan(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<AllanArguments>();
  CLI::App* cmd =
      app.add_subcommand("allan", "Noise densities and bias instability from a recording at rest");
  cmd->footer(
      "Example: magimu allan rest.csv -o noise.json --report noise.html\n"
      "         magimu calibrate rec.csv --noise noise.json\n"
      "A minute at rest gives the white noise, an hour the bias instability, several hours the\n"
      "random walk. Exit code 1: the device moves, or the rest is too short; 2: wrong usage or\n"
      "unreadable input; 70: a defect of magimu: please report it.");
  cmd->add_option("recording", args->recordings, "of a device that lies still")
      ->required()
      ->expected(1)
      ->transform(standard_input())
      ->type_name("REC");
  add_output(*cmd, "-o,--output", args->output, "write the densities here, for calibrate --noise",
             "NOISE.json");
  add_output(*cmd, "--report", args->report, "write a page with Allan plots here", "R.html");
  add_reading_options(*cmd, *args);
  add_output_options(*cmd, *args, "print the noise file instead of the text");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
