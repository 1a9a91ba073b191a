// SPDX-License-Identifier: BSD-3-Clause
// `magimu export CAL.json --to px4|ardupilot|ros|matlab|c`
#include "calibration/use/export.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/options/axes_of_calibration.h"
#include "apps/options/common_options.h"
#include "apps/options/outputs.h"
#include "apps/say/trusted.h"
#include "calibration/result/calibration_json.h"
#include "calibration/use/applied_json.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

const std::map<std::string, ExportTarget> kTargets{{"px4", ExportTarget::kPx4},
                                                   {"ardupilot", ExportTarget::kArdupilot},
                                                   {"ros", ExportTarget::kRos},
                                                   {"matlab", ExportTarget::kMatlab},
                                                   {"c", ExportTarget::kC}};

struct ExportArguments : RecordingOptions {
  std::string calibration, output = "/dev/stdout", target;
  ExportOptions options;
  bool force = false, allow_loss = false;
};

// A file that makes headings wrong is not written, unless the user insists.
bool may_be_written(const Exported& out, const ExportArguments& args) {
  for (const std::string& sentence : out.harmful) {
    fmt::print(stderr, "magimu: {}: {}{}\n", args.calibration, sentence,
               args.allow_loss ? "" : " Or write the file all the same: --allow-loss.");
  }
  return out.harmful.empty() || args.allow_loss;
}

int run(ExportArguments& args) {
  check_outputs({args.calibration}, {args.output});
  const nlohmann::ordered_json file = read_calibration_json(args.calibration);
  const Calibration c = calibration_from_json(file, args.calibration);
  if (!may_be_used(c, args.calibration, args.force)) return kNoAnswer;
  args.options.turned = axes_in(file);
  args.options.applied = applied_from_json(file, args.calibration);
  args.options.source = std::filesystem::path(args.calibration).filename().string();
  const Exported out = export_calibration(c, kTargets.at(args.target), args.options);
  if (!may_be_written(out, args)) return kUnusable;
  if (args.json) {
    const nlohmann::ordered_json json = {
        {"to", args.target}, {"text", out.text}, {"lost", out.lost}};
    write_atomically(args.output, json.dump(2) + "\n");
  } else {
    write_atomically(args.output, out.text);
  }
  if (args.quiet) return kDone;
  for (const std::string& warning : c.warnings) {
    fmt::print(stderr, "magimu: {}: {}\n", args.calibration, warning);
  }
  for (const std::string& sentence : out.lost) {
    fmt::print(stderr, "magimu: not carried to {}: {}\n", args.target, sentence);
  }
  return kDone;
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<ExportArguments>();
  CLI::App* cmd = app.add_subcommand(
      "export", "Write a calibration in another system's own names, units and convention");
  cmd->footer(
      "Example: magimu export cal.json --to px4 -o cal.params\n"
      "What the other system has no parameter for is said, here and in the file.\n"
      "Exit code 1: the calibration says of itself that it must not be used (--force: do it\n"
      "all the same); 2: wrong usage or unreadable input, or a file that would make headings "
      "wrong\n"
      "(--allow-loss: write it all the same); 70: a defect of magimu: please report it.");
  cmd->add_option("calibration", args->calibration, "written by `magimu calibrate -o`")
      ->required()
      ->type_name("CAL.json");
  std::vector<std::string> names;
  for (const auto& [name, target] : kTargets) names.push_back(name);
  cmd->add_option("--to", args->target,
                  "px4: parameters for QGroundControl; ardupilot: a .param file; ros: YAML; "
                  "matlab: A, b of magcal; c: a header")
      ->required()
      ->check(CLI::IsMember(names));
  add_output(*cmd, "-o,--output", args->output, "the file (default: standard output)", "FILE");
  cmd->add_option(
         "--field-strength", args->options.strength_uT,
         "length of corrected magnetometer readings, uT: the field's true strength at your "
         "place (default: the calibration's own)")
      ->check(CLI::Range(1.0, 1000.0))
      ->type_name("UT");
  cmd->add_flag("--with-rotation", args->options.with_rotation,
                "px4, ardupilot: carry the magnetometer's rotation against the IMU as mounting\n"
                "angles (PX4 1.14, ArduPilot 4.2 and later; external magnetometers)");
  repeatable(
      cmd->add_option(
             "--only", args->options.only,
             "px4, ardupilot: write the parameters of this sensor only, such as mag (several:\n"
             "repeat); those of the others stay as they are on the vehicle")
          ->type_name("SENSOR")
          ->check(CLI::IsMember({"mag", "acc", "gyr"})));
  cmd->add_flag("--allow-loss", args->allow_loss,
                "px4, ardupilot: write a file that loses a large rotation of a magnetometer, too");
  cmd->add_flag("--force", args->force, "use a calibration whose verdict is \"no\"");
  add_output_options(*cmd, *args, "write a JSON object with the text and what is lost");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
