// SPDX-License-Identifier: BSD-3-Clause
// `magimu apply CAL.json REC -o OUT.csv`
#include "calibration/use/apply.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/options/axes_of_calibration.h"
#include "apps/options/common_options.h"
#include "apps/options/outputs.h"
#include "apps/say/progress.h"
#include "apps/say/trusted.h"
#include "calibration/result/calibration_json.h"
#include "recording/checks/quality.h"
#include "recording/csv/csv.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

struct ApplyArguments : RecordingOptions {
  std::string calibration, output;
  bool force = false, keep_times = false;
};

std::string in_words(const Applied& applied) {
  std::string out;
  for (const std::string& formula : applied.formulas) out += formula + "\n";
  for (const std::string& effect : applied.not_applied) out += "Not applied: " + effect + "\n";
  return out;
}

// Rows of a file in which both an accelerometer and a magnetometer have a sample.
std::size_t common_rows(const Recording& r) {
  std::size_t rows = 0;
  for (const VectorSeries& mag : r.mag) {
    std::vector<double> common;
    std::ranges::set_intersection(r.acc.t, mag.t, std::back_inserter(common));
    rows = std::max(rows, common.size());
  }
  return rows;
}

// A lag that was taken out moves magnetometer samples out of the rows they shared.
std::string own_rows_note(const Recording& before, const Recording& after) {
  const std::size_t shared = common_rows(before);
  if (shared == 0 || common_rows(after) >= shared / 2) return "";
  return "The magnetometer's lag is taken out of its times, so that its samples are in rows of "
         "their own;\n--keep-times leaves them in the rows where they were.\n";
}

int run(const ApplyArguments& args) {
  check_outputs({args.calibration, args.recordings.front()}, {args.output});
  const nlohmann::ordered_json file = read_calibration_json(args.calibration);
  const Calibration c = calibration_from_json(file, args.calibration);
  if (!may_be_used(c, args.calibration, args.force)) return kNoAnswer;
  check_same_axes(file, args.calibration, args);
  const std::vector<Recording> recordings = read_recordings(args);
  refuse_fatal(recordings.front(), check_units(recordings.front()));
  const Applied applied = with_bar(!args.quiet, "correcting " + recordings.front().name, [&] {
    Applied out = apply(c, recordings.front(), {.move_mag_times = !args.keep_times});
    write_atomically(args.output, csv_text(out.recording));
    return out;
  });
  std::FILE* const where = where_words_go(args.output);
  if (args.json) {
    const nlohmann::ordered_json json = {{"recording", recordings.front().name},
                                         {"output", args.output},
                                         {"formulas", applied.formulas},
                                         {"not_applied", applied.not_applied},
                                         {"doubts", applied.doubts}};
    fmt::print(where, "{}\n", json.dump(2));
  } else if (!args.quiet) {
    fmt::print(where, "{}: {} IMU samples, corrected with {} (trust: {})\n\n{}{}", args.output,
               applied.recording.gyr.size(), args.calibration, to_string(c.trust.verdict),
               in_words(applied), own_rows_note(recordings.front(), applied.recording));
  }
  for (const std::string& doubt : applied.doubts) {
    if (!args.quiet && !args.json) fmt::print(where, "\nWarning: {}\n", doubt);
  }
  return kDone;
}

}  // namespace

void add_apply(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<ApplyArguments>();
  CLI::App* cmd =
      app.add_subcommand("apply", "Correct a recording with a calibration, in the IMU's axes");
  cmd->footer(
      "Example: magimu apply cal.json rec.csv -o corrected.csv\n"
      "The formula is printed with its numbers. Readings stay in m/s^2, rad/s and uT.\n"
      "Exit code 1: the calibration says of itself that it must not be used (--force: do it\n"
      "all the same); 2: wrong usage or unreadable input; 70: a defect of magimu: please report "
      "it.");
  cmd->add_option("calibration", args->calibration, "written by `magimu calibrate -o`")
      ->required()
      ->type_name("CAL.json");
  cmd->add_option("recording", args->recordings, kRecordingFormats)
      ->required()
      ->expected(1)
      ->transform(standard_input())
      ->type_name("REC");
  add_output(*cmd, "-o,--output", args->output, "the corrected recording", "OUT.csv")->required();
  cmd->add_flag("--keep-times", args->keep_times,
                "leave magnetometer samples where they are, although the magnetometer lags");
  cmd->add_flag("--force", args->force, "use a calibration whose verdict is \"no\"");
  add_reading_options(*cmd, *args);
  add_output_options(*cmd, *args, "print the formulas as JSON");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
