// SPDX-License-Identifier: BSD-3-Clause
// `magimu diagnose REC... -o DIAG.json --report R.html`
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "apps/commands.h"
#include "apps/copies.h"
#include "apps/options/axes_of_calibration.h"
#include "apps/options/common_options.h"
#include "apps/options/outputs.h"
#include "apps/page/diagnosis_report.h"
#include "apps/page/report_provenance.h"
#include "apps/say/diagnosis_answer.h"
#include "apps/say/diagnosis_table.h"
#include "apps/say/progress.h"
#include "calibration/result/calibration_json.h"
#include "diagnosis/result/diagnosis_json.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

struct DiagnoseArguments : RecordingOptions {
  std::string output, report, against, base, magnetometer;
  double false_alarm_rate = DiagnosisOptions{}.false_alarm_rate;
};

// The magnetometer that is asked about comes first.
void put_first(const std::string& name, Recording& recording) {
  const auto at = std::ranges::find(recording.mag_names, name);
  if (at == recording.mag_names.end()) {
    throw InputError(recording.name, 0, 0, "there is no magnetometer " + name,
                     fmt::format("there are {}", fmt::join(recording.mag_names, ", ")));
  }
  const auto place = at - recording.mag_names.begin();
  std::rotate(recording.mag_names.begin(), at, at + 1);
  std::rotate(recording.mag.begin(), recording.mag.begin() + place,
              recording.mag.begin() + place + 1);
}

int run(DiagnoseArguments& args) {
  std::vector<std::string> inputs = args.recordings;
  inputs.insert(inputs.end(), {args.against, args.base});
  check_outputs(inputs, {args.output, args.report});
  std::optional<tbb::global_control> limit;
  if (args.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(args.threads));
  }
  DiagnosisOptions options;
  options.noise = args.noise();
  options.gravity = args.gravity;
  options.motion = args.motion_model();
  options.false_alarm_rate = args.false_alarm_rate;
  if (!args.against.empty()) {
    const nlohmann::ordered_json file = read_calibration_json(args.against);
    options.against = calibration_from_json(file, args.against);
    options.against_name = args.against;
    check_same_axes(file, args.against, args);
  }
  if (!args.base.empty()) {
    const nlohmann::ordered_json file = read_calibration_json(args.base);
    options.base = calibration_from_json(file, args.base);
    check_same_axes(file, args.base, args);
  }
  const std::vector<GivenCopy> copies = leave_out_copies(args.recordings);
  std::vector<Recording> recordings = read_recordings(args);
  caution_of_copies(copies, recordings);
  for (Recording& r : recordings) {
    if (!args.magnetometer.empty()) put_first(args.magnetometer, r);
  }
  Diagnosis d;
  {
    ProgressBar bar(!args.quiet);
    options.progress = [&bar](const std::string& what, double share) { bar(what, share); };
    d = diagnose(pointers(recordings), options);
  }
  // Names of files need not be UTF-8.
  nlohmann::ordered_json file = to_json(d);
  file["provenance"] = provenance_json(args.recordings);
  const std::string json =
      file.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (!args.output.empty()) write_atomically(args.output, json);
  if (!args.report.empty()) write_atomically(args.report, diagnosis_report(d));
  if (args.json) {
    if (!is_standard_output(args.output)) fmt::print("{}", json);
  } else if (!args.quiet) {
    fmt::print(where_words_go(args.output), "{}", diagnosis_table(d));
  }
  if (d.answer != Answer::kNone) return kDone;
  fmt::print(stderr, "magimu: {}\n", headline(d));
  for (const std::string& reason : d.evidence) fmt::print(stderr, "  {}\n", reason);
  return kNoAnswer;
}

}  // namespace

void add_diagnose(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<DiagnoseArguments>();
  CLI::App* cmd = app.add_subcommand(
      "diagnose", "Find what the simulation of the sensor gets wrong in recordings, and why");
  cmd->footer(
      "Example: magimu diagnose hand_rotation.csv -o diag.json --report diag.html\n"
      "Names causes (a lag of the magnetometer, a drifting bias, a magnet that came near, ...) "
      "with\n"
      "their size, its uncertainty and what they gain on data the fit has not seen; says what it\n"
      "looked for and did not find, and what it could not have seen.\n"
      "Is a calibration of last year still good: magimu diagnose new.csv --against old_cal.json\n"
      "Exit code 0: there is an answer, also \"nothing is wrong\"; 1: the data do not permit one\n"
      "(files are written all the same); 2: wrong usage or unreadable input; 70: a defect of "
      "magimu:\n"
      "please report it.");
  add_recording_options(*cmd, *args);
  add_output(*cmd, "-o,--output", args->output, "write the diagnosis here", "DIAG.json");
  add_output(*cmd, "--report", args->report,
             "write a page with pictures here: one file, no network", "R.html");
  cmd->add_option("--against", args->against,
                  "does this calibration still predict these recordings, and what has changed?")
      ->type_name("CAL.json");
  cmd->add_option("--base", args->base,
                  "start from the model of this calibration (its motion and effects, its noise if\n"
                  "it was given) instead of the sensor that only turns, with 19 parameters")
      ->excludes("--motion")
      ->type_name("CAL.json");
  cmd->add_option("--magnetometer", args->magnetometer,
                  "of an array: which one is asked what it lacks (default: the first)")
      ->type_name("NAME");
  cmd->add_option("--false-alarm-rate", args->false_alarm_rate,
                  "how often anything at all may be named where there is nothing")
      ->capture_default_str()
      ->check(CLI::Range(1e-6, 0.5))
      ->type_name("P");
  add_output_options(*cmd, *args, "print the diagnosis file instead of the text");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
