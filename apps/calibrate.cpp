// SPDX-License-Identifier: BSD-3-Clause
// `magimu calibrate REC... -o CAL.json`
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "apps/commands.h"
#include "apps/copies.h"
#include "apps/options/axes_of_calibration.h"
#include "apps/options/common_options.h"
#include "apps/options/outputs.h"
#include "apps/options/place_options.h"
#include "apps/options/prior_options.h"
#include "apps/page/report_calibration.h"
#include "apps/page/report_provenance.h"
#include "apps/say/calibration_table.h"
#include "apps/say/progress.h"
#include "calibration/calibrate.h"
#include "calibration/result/calibration_json.h"
#include "calibration/result/json_text.h"
#include "calibration/rivals/rival_calibration.h"
#include "calibration/use/applied_json.h"
#include "graph/numerical_error.h"
#include "navigation/array_layout.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

struct CalibrateArguments : RecordingOptions {
  std::string output, trajectory, report, backend = "auto", mag_time_offset = "auto",
                                          gyro_matrix = "auto", method = "map";
  std::string layout;
  bool as_published = false, joint_covariance = false;
  double dip_deg = 0.0;
  bool has_dip = false;
  PlaceOptions place;
  PriorArguments prior;
  CalibrationOptions options;
};

Backend backend_named(const std::string& name) {
  if (name == "chain") return Backend::kChain;
  if (name == "cholmod") return Backend::kCholmod;
  if (name == "spqr") return Backend::kSpqr;
  if (name == "eigen") return Backend::kEigen;
  return Backend::kAuto;
}

std::string trajectory_csv(const Calibration& c) {
  const bool several = c.trajectories.size() > 1;
  const bool moving = is_moved(c.motion);
  std::string out = several ? "recording,t,qw,qx,qy,qz" : "t,qw,qx,qy,qz";
  out += moving ? ",vx,vy,vz,px,py,pz\n" : "\n";
  for (std::size_t r = 0; r < c.trajectories.size(); ++r) {
    const TrajectoryEstimate& trajectory = c.trajectories[r];
    for (std::size_t k = 0; k < trajectory.t.size(); ++k) {
      if (several) out += fmt::format("{},", r);
      const Vector4& q = trajectory.nRb[k].quaternion();
      out += fmt::format("{},{},{},{},{}", trajectory.t[k], q[0], q[1], q[2], q[3]);
      if (moving) {
        const Vector3 &v = trajectory.v[k], &p = trajectory.p[k];
        out += fmt::format(",{},{},{},{},{},{}", v[0], v[1], v[2], p[0], p[1], p[2]);
      }
      out += "\n";
    }
  }
  return out;
}

// By a rival of the MAP; what it does not estimate is said with the result.
RivalCalibration run_rival(const CalibrateArguments& args,
                           const std::vector<const Recording*>& recordings) {
  if (is_moved(args.motion_model())) {
    throw InputError("--method", 0, 0, args.method + " knows no sensor that is moved",
                     "leave out --motion, or use --method map");
  }
  RivalOptions rival;
  rival.method = args.method == "wu" ? RivalMethod::kWu : RivalMethod::kKok;
  rival.as_published = args.as_published;
  std::string why;
  std::optional<RivalCalibration> made =
      attempt([&] { return calibrate_by(rival, recordings, args.options); }, &why);
  if (!made) {
    throw InputError(recordings.front()->name, 0, 0, "no calibration by this method: " + why,
                     "use --method map, which says what is missing");
  }
  return *std::move(made);
}

// Method, and what it leaves out.
std::string said_of(const RivalCalibration& rival) {
  std::string out = fmt::format("Method: {}. Not estimated or looked at:\n", rival.method);
  for (const std::string& text : rival.not_estimated) out += "  - " + text + "\n";
  return out + "\n";
}

// Where the magnetometers sit, into their entries.
void give_positions(const CalibrateArguments& args, Calibration& c) {
  if (args.layout.empty()) return;
  const std::vector<Vector3> places = read_array_layout(args.layout);
  if (places.size() != c.parameters.mag.size()) {
    throw InputError(args.layout, 0, 0,
                     fmt::format("it has {} places, the recording {} magnetometers", places.size(),
                                 c.parameters.mag.size()),
                     "give a line for each magnetometer, in the order of the recording");
  }
  c.magnetometers.resize(places.size());  // without a fit there are none
  for (std::size_t m = 0; m < places.size(); ++m) c.magnetometers[m].position = places[m];
}

int run(CalibrateArguments& args) {
  const bool rivals = args.method != "map";
  if (args.as_published && !rivals) {
    throw InputError("--as-published", 0, 0, "it is for --method kok and wu",
                     "name one of them, or leave it out");
  }
  if (rivals && !args.report.empty()) {
    throw InputError("--report", 0, 0, "the page is made from the MAP's residuals",
                     "leave out --report, or use --method map");
  }
  std::vector<std::string> inputs = args.recordings;
  inputs.push_back(args.layout);
  check_outputs(inputs, {args.output, args.trajectory, args.report});
  std::optional<tbb::global_control> limit;
  if (args.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(args.threads));
  }
  args.options.noise = args.noise();
  args.options.gravity = args.place.gravity_or(args.gravity);
  args.options.motion = args.motion_model();
  args.options.dip_sign = args.place.dip_sign();
  const KnownField known = args.place.known_field();
  if (args.has_dip) {
    args.options.initialization.dip_rad = args.dip_deg * kDegree;
  } else if (known.field) {
    args.options.initialization.dip_rad = known.field->dip_rad;
  }
  if (args.gyro_matrix != "auto") args.options.gyr_matrix = args.gyro_matrix == "on";
  if (args.mag_time_offset != "auto") args.options.mag_time_offset = args.mag_time_offset == "on";
  args.options.optimizer.backend = backend_named(args.backend);

  args.prior.apply_to(args.options, args);
  const std::vector<GivenCopy> copies = leave_out_copies(args.recordings);
  std::vector<Recording> recordings = read_recordings(args);
  caution_of_copies(copies, recordings);
  if (args.place.prior) args.options.also = field_prior(*known.field, int(recordings.size()));
  std::optional<RivalCalibration> rival;
  Calibration c;
  {
    ProgressBar bar(!args.quiet);
    args.options.progress = [&bar](const std::string& what, double share) { bar(what, share); };
    if (rivals) {
      bar(args.method);
      rival = run_rival(args, pointers(recordings));
      c = rival->calibration;
    } else {
      c = calibrate(pointers(recordings), args.options);
    }
  }
  check_field(c, known);
  give_positions(args, c);
  nlohmann::ordered_json file = to_json(c, args.joint_covariance);
  file["method"] = rival ? rival->method : "map";
  file["axes"] = axes_json(args);
  add_applied(file, pointers(recordings));
  file["provenance"] = provenance_json(args.recordings);
  if (rival) file["not_estimated"] = rival->not_estimated;
  const std::string json = json_text(file);
  if (!args.output.empty()) write_atomically(args.output, json);
  if (!args.trajectory.empty()) write_atomically(args.trajectory, trajectory_csv(c));
  if (!args.report.empty()) {
    write_atomically(args.report, calibration_report(c, pointers(recordings)));
  }
  if (args.json) {
    if (!is_standard_output(args.output)) fmt::print("{}", json);
  } else if (!args.quiet) {
    fmt::print(where_words_go(args.output), "{}{}", rival ? said_of(*rival) : "",
               calibration_table(c));
  }
  if (c.trust.verdict != Verdict::kNo) return kDone;
  fmt::print(stderr, "magimu: {}: do not use this calibration: {}\n",
             fmt::join(args.recordings, ", "), c.trust.reasons.front());
  return kNoAnswer;
}

}  // namespace

void add_calibrate(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<CalibrateArguments>();
  CLI::App* cmd = app.add_subcommand(
      "calibrate", "Estimate biases, distortion and dip from recordings of one device");
  cmd->footer(
      "Example: magimu calibrate hand_rotation.csv -o cal.json\n"
      "Turn the sensor on the spot, slowly, about all three of its axes, for a minute or more.\n"
      "Exit code 1: the data do not permit a calibration (the file is written all the same,\n"
      "marked \"no\"); 2: wrong usage or unreadable input; 70: a defect of magimu: please report "
      "it.");
  add_recording_options(*cmd, *args);
  add_output(*cmd, "-o,--output", args->output, "write the calibration here", "CAL.json");
  add_output(*cmd, "--trajectory", args->trajectory, "write the estimated orientations here",
             "T.csv");
  add_output(*cmd, "--report", args->report,
             "write a page with pictures here: one file, no network", "R.html");
  cmd->add_option_function<double>(
         "--dip",
         [args](double dip) {
           args->dip_deg = dip;
           args->has_dip = true;
         },
         "start from this dip, degrees, positive downward (default: from the data)")
      ->check(CLI::Range(-89.9, 89.9))
      ->type_name("DEG");
  add_place_options(*cmd, args->place);
  add_prior_options(*cmd, args->prior);
  cmd->add_option("--mag-time-offset", args->mag_time_offset,
                  "estimate the magnetometer's lag: auto (where the data show one), on, off (nor "
                  "the accelerometer's)")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "on", "off"}));
  cmd->add_option(
         "--gyro-matrix", args->gyro_matrix,
         "estimate the gyroscope's scale errors and misalignment: auto (where left-out data "
         "are predicted better; with them the accelerometer's, and the gyroscope's response to "
         "gravity, where the data show them), on, off (none of these)")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "on", "off"}));
  cmd->add_option("--method", args->method,
                  "map: joint maximum a posteriori; kok: maximum likelihood of Kok and Schoen; wu: "
                  "the filter of Wu et al. (both for a sensor that only turns)")
      ->capture_default_str()
      ->check(CLI::IsMember({"map", "kok", "wu"}));
  cmd->add_flag("--as-published", args->as_published,
                "kok and wu as code published with Huang et al. 2025 runs them");
  cmd->add_option("--layout", args->layout,
                  "where the magnetometers of an array sit: a line x,y,z, then m for each in the "
                  "IMU's frame; goes into the file, for `magimu navigate`")
      ->check(CLI::ExistingFile)
      ->type_name("LAYOUT.csv");
  cmd->add_flag("--joint-covariance", args->joint_covariance,
                "of an array: write the covariance of all parameters, not in blocks; needed where "
                "the file is to be a --prior");
  cmd->add_option("--node-every", args->options.node_every,
                  "magnetometer samples per node; all samples are averaged in (0: automatic)")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000))
      ->type_name("N");
  cmd->add_option("--solver", args->backend, "linear back end")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "chain", "cholmod", "spqr", "eigen"}));
  add_output_options(*cmd, *args, "print the calibration file instead of the table");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
