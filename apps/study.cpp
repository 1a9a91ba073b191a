// SPDX-License-Identifier: BSD-3-Clause
// `magimu study NAME -o DIR`
#include "study/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/options/outputs.h"
#include "apps/say/progress.h"
#include "apps/study_files.h"
#include "recording/data/error.h"

namespace magimu::apps {
namespace {

struct StudyArguments {
  std::vector<std::string> names;
  std::string folder;
  StudyOptions options;
  bool json = false, quiet = false;
};

std::vector<std::string> experiments_of(const StudyArguments& args) {
  std::vector<std::string> names;
  for (const std::string& name : args.names) {
    if (name == "all") return study_names();
    names.push_back(name);
  }
  return names;
}

void print_study(const Study& study) {
  fmt::print("{} ({:.0f} s): {}\n", study.name, study.seconds, study.title);
  for (const std::string& finding : study.findings) fmt::print("  - {}\n", finding);
  for (const StudyCheck& check : study.checks) {
    if (check.inside()) continue;
    const std::string where = std::isinf(check.high)  ? fmt::format("less than {:.4g}", check.low)
                              : std::isinf(check.low) ? fmt::format("more than {:.4g}", check.high)
                                                      : fmt::format("not within {:.4g} and {:.4g}",
                                                                    check.low, check.high);
    fmt::print("  {}: {:.4g}, {} ({})\n", check.what, check.value, where,
               !check.by_chance      ? "a limit"
               : check.inside_wide() ? "outside of the 99 % band"
                                     : "outside of the 99.99 % band");
  }
}

int run(StudyArguments& args) {
  const std::vector<std::string> names = experiments_of(args);
  check_study_folder(args.folder);
  std::vector<Study> studies;
  {
    ProgressBar bar(!args.quiet);
    args.options.progress = [&bar](const std::string& what, double share) { bar(what, share); };
    studies = run_studies(names, args.options);
  }
  const auto files = study_files(studies, args.options);
  write_study_folder(args.folder, files);
  const StudyVerdict verdict = judge(studies);
  if (args.json) {
    fmt::print("{}", files.at("study.json"));
  } else if (!args.quiet) {
    for (const Study& study : studies) print_study(study);
    fmt::print("{}\n", verdict.sentence);
    if (args.options.brief && verdict.broken > 0) {
      fmt::print(
          "The limits are those of the full study: few draws, or other work on the machine, may "
          "miss them.\n");
    }
    fmt::print("{}/study.html\n", args.folder);
  }
  return kDone;
}

}  // namespace

void add_study(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<StudyArguments>();
  CLI::App* cmd =
      app.add_subcommand("study", "Repeat the experiments of the paper: tables, figures, one page");
  cmd->footer(
      fmt::format("Experiments: {}, or all of them.\n"
                  "Example: magimu study accuracy rates -o study && xdg-open study/study.html\n"
                  "Into the folder go study.html, study.json, a CSV file a table and an SVG file a "
                  "figure: all\n"
                  "of them or none. An earlier study there is replaced, nothing else is.",
                  fmt::join(study_names(), ", ")));
  std::vector<std::string> choices = study_names();
  choices.emplace_back("all");
  cmd->add_option("name", args->names, "which experiments")
      ->required()
      ->check(CLI::IsMember(choices))
      ->type_name("NAME...");
  add_output(*cmd, "-o,--output", args->folder, "folder for tables, figures and page", "DIR")
      ->required();
  cmd->add_option("--runs", args->options.runs,
                  "data sets of each setting; slow methods have fewer, and say so")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000))
      ->type_name("N");
  cmd->add_flag("--short", args->options.brief,
                "few data sets and settings: does it work? (half a minute)");
  cmd->add_option("--recordings", args->options.recordings,
                  "a folder of MATLAB files of the OC-MAINS set, for downstream")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
  cmd->add_option("--threads", args->options.threads,
                  "data sets at a time (0: as many as there are processors)")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd->add_flag("--json", args->json, "print study.json");
  cmd->add_flag("-q,--quiet", args->quiet, "print nothing but errors");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
