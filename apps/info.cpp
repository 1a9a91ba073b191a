// SPDX-License-Identifier: BSD-3-Clause
// `magimu info REC`
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "apps/commands.h"
#include "apps/options/common_options.h"
#include "apps/options/outputs.h"
#include "apps/options/place_options.h"
#include "apps/page/report_survey.h"
#include "apps/say/progress.h"
#include "apps/say/survey_report.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

struct InfoArguments : RecordingOptions {
  PlaceOptions place;
  std::string report;
};

int run(const InfoArguments& args) {
  check_outputs(args.recordings, {args.report});
  std::optional<tbb::global_control> limit;
  if (args.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(args.threads));
  }
  bool usable = true, first = true;
  nlohmann::json all = nlohmann::json::array();
  std::vector<SurveyedRecording> looked_at;
  const std::vector<Recording> recordings = read_recordings(args);
  for (const Recording& recording : recordings) {
    SurveyOptions options;
    options.noise = args.noise();
    options.gravity = args.place.gravity_or(args.gravity);
    options.dip_sign = args.place.dip_sign();
    options.motion = args.motion_model();
    Survey s;
    {
      ProgressBar progress(!args.quiet);
      options.progress = [&progress](const std::string& what, double share) {
        progress(what, share);
      };
      s = survey(recording, options);
    }
    usable = usable && s.usable();
    if (args.json) {
      all.push_back(survey_json(s, recording.notes));
    } else if (!args.quiet) {
      fmt::print("{}{}", first ? "" : "\n", survey_text(s));
    }
    first = false;
    looked_at.push_back({&recording, s, survey_verdict(s)});
    if (!s.usable()) {
      // Why, the last line above says.
      const bool said = (!args.quiet && !args.json) || s.not_looked_further.empty();
      fmt::print(stderr, "magimu: {}: do not calibrate this recording as it is{}\n", s.recording,
                 said ? "" : ": " + s.not_looked_further);
    }
  }
  if (!args.report.empty()) write_atomically(args.report, survey_page(looked_at));
  if (args.json) fmt::print("{}\n", (all.size() == 1 ? all.front() : all).dump(2));
  return usable ? kDone : kNoAnswer;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<InfoArguments>();
  CLI::App* cmd = app.add_subcommand(
      "info",
      "Look at a recording before calibrating: sensors, faults, axes, motion, what is missing");
  cmd->footer(
      "Example: magimu info hand_rotation.csv\n"
      "         magimu info phone.csv --unit gyr=deg/s --map mag_x=Bx --map mag_y=By --map "
      "mag_z=Bz\n"
      "Exit code 1: the recording cannot be calibrated as it is (it says why, and what to do);\n"
      "2: wrong usage or unreadable input; 70: a defect of magimu: please report it.");
  add_recording_options(*cmd, *args);
  add_output(*cmd, "--report", args->report,
             "write a page with pictures here: one file, no network", "R.html");
  add_place_options(*cmd, args->place);
  add_output_options(*cmd, *args, "print the same as JSON (docs/formats.md)");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
