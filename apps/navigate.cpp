// SPDX-License-Identifier: BSD-3-Clause
// `magimu navigate REC [--calibration CAL.json] -o TRAJECTORY.csv`
#include "navigation/navigate.h"

#include <fmt/format.h>

#include <numbers>

#include "apps/commands.h"
#include "apps/options/common_options.h"
#include "apps/options/number_checks.h"
#include "apps/options/outputs.h"
#include "apps/say/progress.h"
#include "apps/say/trusted.h"
#include "calibration/result/calibration_json.h"
#include "calibration/use/apply.h"
#include "navigation/array_layout.h"
#include "navigation/navigation_errors.h"
#include "navigation/navigation_output.h"
#include "navigation/truncation.h"
#include "recording/arrays/array_mat.h"
#include "recording/checks/quality.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

constexpr double kDegreesInRad = 180.0 / std::numbers::pi;
// Of the published recordings and filters, m/s^2.
constexpr double kPublishedGravity = 9.82;

struct NavigateArguments : ReadingOptions {
  std::vector<std::string> files;  // the recording; or the calibration and the recording
  std::string recording, calibration, layout, output;
  std::string method = "oc-mains", truncation = "coloured", readings = "mean";
  int order = 2, threads = 0;
  double gravity = 0.0, aided_s = 0.0, mag_bias_uT = 0.0;
  std::vector<double> noise;
  bool force = false, json = false, quiet = false;
};

struct Input {
  Recording recording;
  std::optional<NavigationStart> start;
  double gravity = kStandardGravity;
};

Input read_input(const NavigateArguments& args) {
  Input input;
  if (std::optional<ArrayFile> file = read_array_mat(args.recording)) {
    if (!args.map.empty() || !args.unit.empty() || !args.axes.empty() || !args.sensors.empty() ||
        !args.columns.empty() || args.rate_hz > 0.0) {
      throw InputError(args.recording, 0, 0,
                       "this is a file of the OC-MAINS set, whose fields and units are known",
                       "leave --map, --unit, --axes, --rate, --columns and --sensor out");
    }
    input.recording = std::move(file->recording);
    if (file->start)
      input.start = NavigationStart{file->start->p, file->start->v, file->start->nRb};
    input.gravity = kPublishedGravity;
  } else {
    input.recording = read_with(args.recording, args, args.quiet);
  }
  if (args.gravity > 0.0) input.gravity = args.gravity;
  return input;
}

// Where a calibration has all magnetometers; else empty.
std::vector<Vector3> positions_in(const Calibration& c) {
  std::vector<Vector3> out;
  for (const MagnetometerRecord& own : c.magnetometers) {
    if (own.position) out.push_back(*own.position);
  }
  return out.size() == c.parameters.mag.size() ? out : std::vector<Vector3>{};
}

// calibrated: the places that the calibration has.
std::vector<Vector3> layout_of(const NavigateArguments& args, const Recording& recording,
                               const std::vector<Vector3>& calibrated) {
  if (!args.layout.empty()) return read_array_layout(args.layout);
  if (!calibrated.empty()) return calibrated;
  std::vector<Vector3> board = published_array_layout();
  if (recording.mag.size() == board.size()) return board;
  throw InputError(
      args.recording, 0, 0,
      fmt::format("the places of its magnetometers ({}) are not known", recording.mag.size()),
      "give --layout LAYOUT.csv (a line x,y,z, then m for each magnetometer), here or to "
      "`magimu calibrate`");
}

NavigationOptions options_of(const NavigateArguments& args, const Input& input,
                             const ArraySamples& samples) {
  NavigationOptions options;
  options.start = input.start;
  options.aided_s = args.aided_s;
  options.use_magnetometers = args.method != "ins";
  options.filter.order = args.order;
  options.filter.gravity = input.gravity;
  options.filter.constrain_yaw = args.method == "oc-mains";
  options.filter.mag_bias_sigma = args.mag_bias_uT;
  if (!args.noise.empty()) {
    const double rate = input.recording.acc.rate_hz();
    options.filter.acc_noise = args.noise[0] * std::sqrt(rate);
    options.filter.gyr_noise = args.noise[1] * std::sqrt(input.recording.gyr.rate_hz());
  }
  options.filter.field = ArrayFilterOptions::published_process(args.order, 50.0);
  if (args.truncation == "coloured" && options.use_magnetometers) {
    options.filter = with_truncation(options.filter, samples);
  }
  return options;
}

// The claims at the end, in the order of the table.
struct Claims {
  double position_m, velocity, yaw_deg, tilt_deg;
};
Claims claims_of(const NavigationRun& run, std::size_t k) {
  const Eigen::Matrix<double, 9, 9> P = covariance_in_n(run, k);
  return {std::sqrt(P.topLeftCorner<3, 3>().trace()), std::sqrt(P.block<3, 3>(3, 3).trace()),
          std::sqrt(P(8, 8)) * kDegreesInRad, std::sqrt(P(6, 6) + P(7, 7)) * kDegreesInRad};
}

double mean_field_nis(const NavigationRun& run) {
  double sum = 0.0;
  for (const ArrayFilter::Innovation& i : run.innovations) sum += i.nis / i.dof;
  return run.innovations.empty() ? 0.0 : sum / static_cast<double>(run.innovations.size());
}

nlohmann::ordered_json summary_json(const NavigateArguments& args, const NavigationRun& run,
                                    const std::optional<NavigationMetrics>& metrics) {
  const Claims end = claims_of(run, run.t.size() - 1);
  nlohmann::ordered_json json = {{"format", "magimu-navigation/1"},
                                 {"recording", args.recording},
                                 {"method", args.method},
                                 {"order", args.order},
                                 {"truncation", args.truncation},
                                 {"samples", run.t.size()},
                                 {"updates", run.innovations.size()},
                                 {"nis_per_number", mean_field_nis(run)},
                                 {"sigma_at_end",
                                  {{"position_m", end.position_m},
                                   {"velocity_m_s", end.velocity},
                                   {"yaw_deg", end.yaw_deg},
                                   {"tilt_deg", end.tilt_deg}}},
                                 {"seconds", run.seconds}};
  if (metrics) {
    json["against_truth"] = {{"distance_m", metrics->distance_m},
                             {"unaided_distance_m", metrics->unaided_distance_m},
                             {"final_3d_m", metrics->final_3d_m},
                             {"final_horizontal_m", metrics->final_horizontal_m},
                             {"mean_horizontal_m", metrics->mean_horizontal_m},
                             {"final_yaw_deg", metrics->last.yaw * kDegreesInRad},
                             {"position_nees_per_coordinate", metrics->last.position_nees / 3.0}};
  }
  return json;
}

void print_table(const NavigateArguments& args, const NavigationRun& run,
                 const std::optional<NavigationMetrics>& metrics, std::FILE* where) {
  const Claims start = claims_of(run, 0), end = claims_of(run, run.t.size() - 1);
  const Vector3& p = run.states.back().p;
  fmt::print(where, "{}: {:.1f} s by {}, {} updates, {:.0f} times faster than real time\n\n",
             args.recording, run.t.back() - run.t.front(), args.method, run.innovations.size(),
             (run.t.back() - run.t.front()) / std::max(run.seconds, 1e-9));
  fmt::print(where, "{:<22}{:>12}{:>12}\n", "standard deviation", "start", "end");
  fmt::print(where, "{:<22}{:>10.3f} m{:>10.3f} m\n", "position", start.position_m, end.position_m);
  fmt::print(where, "{:<22}{:>8.3f} m/s{:>8.3f} m/s\n", "velocity", start.velocity, end.velocity);
  fmt::print(where, "{:<22}{:>8.2f} deg{:>8.2f} deg\n", "yaw", start.yaw_deg, end.yaw_deg);
  fmt::print(where, "{:<22}{:>8.2f} deg{:>8.2f} deg\n\n", "tilt", start.tilt_deg, end.tilt_deg);
  fmt::print(where, "End at ({:.3f}, {:.3f}, {:.3f}) m.\n", p.x(), p.y(), p.z());
  if (!run.innovations.empty()) {
    fmt::print(where,
               "Normalized innovations squared: {:.2f} per number (1 where the model is "
               "right).\n",
               mean_field_nis(run));
  }
  if (!metrics) return;
  fmt::print(where,
             "Against the truth: {:.3f} m from it at the end, {:.2f} % of {:.1f} m "
             "(horizontally {:.3f} m); NEES {:.2f} per coordinate.\n",
             metrics->final_3d_m, 100.0 * metrics->final_3d_over_distance(), metrics->distance_m,
             metrics->final_horizontal_m, metrics->last.position_nees / 3.0);
}

int run(const NavigateArguments& args) {
  check_outputs({args.recording, args.calibration, args.layout}, {args.output});
  Input input = read_input(args);
  refuse_fatal(input.recording, check_units(input.recording));
  std::vector<Vector3> calibrated;
  if (!args.calibration.empty()) {
    const Calibration c = read_calibration(args.calibration);
    if (!may_be_used(c, args.calibration, args.force)) return kNoAnswer;
    calibrated = positions_in(c);
    std::optional<MotionTruth> truth = input.recording.truth;
    input.recording = apply(c, input.recording).recording;
    input.recording.truth = std::move(truth);
    if (args.gravity <= 0.0) input.gravity = c.gravity;
  }
  const ArraySamples samples =
      array_samples(input.recording, layout_of(args, input.recording, calibrated),
                    args.readings == "held" ? StepReadings::kHeld : StepReadings::kMean);
  if (args.aided_s > 0.0 && samples.true_p.empty()) {
    throw InputError(args.recording, 0, 0, "there is no known position for --aid",
                     "leave --aid out, or give a recording with its truth");
  }
  const NavigationRun result = with_bar(!args.quiet, "navigating", [&] {
    return navigate(samples, options_of(args, input, samples));
  });
  std::optional<NavigationMetrics> metrics;
  if (!samples.true_p.empty()) metrics = navigation_metrics(result, samples, args.aided_s);

  const nlohmann::ordered_json summary = summary_json(args, result, metrics);
  if (args.output.ends_with(".json")) {
    nlohmann::ordered_json json = summary;
    json["trajectory"] = navigation_json(result);
    write_atomically(args.output, json.dump() + "\n");
  } else if (!args.output.empty()) {
    write_atomically(args.output, navigation_csv(result));
  }
  std::FILE* const where = where_words_go(args.output);
  if (args.json) {
    fmt::print(where, "{}\n", summary.dump(2));
  } else if (!args.quiet) {
    print_table(args, result, metrics, where);
  }
  return kDone;
}

void add_filter_options(CLI::App& cmd, NavigateArguments& args) {
  cmd.add_option(
         "--method", args.method,
         "mains; oc-mains (or oc): yaw's uncertainty does not shrink where nothing observes it; "
         "ins: without magnetometers")
      ->capture_default_str()
      ->check(CLI::IsMember({"mains", "oc-mains", "oc", "ins"}));
  cmd.add_option("--order", args.order, "degree of the field's polynomials")
      ->capture_default_str()
      ->check(CLI::Range(1, 3))
      ->type_name("N");
  cmd.add_option("--truncation", args.truncation,
                 "what the polynomials leave out: coloured (the next degree as states), or white "
                 "noise a step as published")
      ->capture_default_str()
      ->check(CLI::IsMember({"coloured", "white"}));
  cmd.add_option("--step-readings", args.readings,
                 "force and rate of a step: its mean, or the sample at its start as published")
      ->capture_default_str()
      ->check(CLI::IsMember({"mean", "held"}));
  cmd.add_option("--aid", args.aided_s, "seconds from the start in which the position is known")
      ->check(nonnegative_number())
      ->type_name("S");
  cmd.add_option("--mag-bias", args.mag_bias_uT,
                 "estimate the magnetometers' biases, with this standard deviation, uT")
      ->check(nonnegative_number())
      ->type_name("UT");
  cmd.add_option("--noise", args.noise, "noise densities per sqrt(Hz): m/s^2 rad/s")
      ->expected(2)
      ->check(positive_number())
      ->type_name("ACC GYR");
  cmd.add_option("--gravity", args.gravity,
                 "m/s^2; else the calibration's, 9.82 with a published recording, or 9.80665")
      ->check(positive_number())
      ->type_name("G");
}

}  // namespace

void add_navigate(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<NavigateArguments>();
  CLI::App* cmd = app.add_subcommand(
      "navigate", "Follow an array of magnetometers with an IMU: position, velocity, attitude");
  cmd->footer(
      "Examples:\n"
      "  magimu navigate cal.json walk.csv --layout board.csv -o walk_path.csv\n"
      "  magimu navigate exp_square_1.mat -o path.json\n"
      "  magimu navigate exp_square_1.mat --method mains --truncation white --step-readings held\n"
      "The last is the filter as published. The field must differ from place to place, as "
      "indoors.\n"
      "Position and yaw are relative to the start. docs/formats.md has the files.\n"
      "Exit code 1: the calibration says of itself that it must not be used (--force: do it\n"
      "all the same); 2: wrong usage or unreadable input; 70: a defect of magimu: please report "
      "it.");
  cmd->add_option("files", args->files,
                  "CSV with mag1_x.. of several magnetometers, or a MATLAB file of the OC-MAINS "
                  "set; before it the array's calibration, as --calibration")
      ->required()
      ->expected(1, 2)
      ->type_name("[CAL.json] REC");
  cmd->add_option("--calibration", args->calibration, "of the array, by `magimu calibrate -o`")
      ->type_name("CAL.json");
  cmd->add_option("--layout", args->layout,
                  "where the magnetometers sit: a line x,y,z, then m for each; 30 of them without "
                  "it are the published board")
      ->type_name("LAYOUT.csv");
  add_output(*cmd, "-o,--output", args->output, "the trajectory with its covariance",
             "OUT.csv|OUT.json");
  add_filter_options(*cmd, *args);
  cmd->add_flag("--force", args->force, "use a calibration whose verdict is \"no\"");
  add_reading_options(*cmd, *args);
  cmd->add_option("--threads", args->threads, "as in other commands; one is used")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd->add_flag("--json", args->json, "print the summary as JSON");
  cmd->add_flag("-q,--quiet", args->quiet, "print nothing but errors");
  cmd->callback([args, &exit_code] {
    if (args->files.size() == 2 && !args->calibration.empty()) {
      throw CLI::ValidationError("--calibration", "a calibration is given twice");
    }
    if (args->files.size() == 2) args->calibration = args->files.front();
    args->recording = args->files.back();
    if (args->method == "oc") args->method = "oc-mains";
    exit_code = run(*args);
  });
}

}  // namespace magimu::apps
