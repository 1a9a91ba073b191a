// SPDX-License-Identifier: BSD-3-Clause
// `magimu simulate -o REC.csv`
#include <fmt/format.h>

#include <optional>

#include "apps/commands.h"
#include "apps/options/number_checks.h"
#include "apps/options/outputs.h"
#include "apps/options/reading_options.h"
#include "apps/replica.h"
#include "apps/say/progress.h"
#include "recording/csv/csv.h"
#include "recording/files/atomic_file.h"
#include "sim/simulate.h"
#include "sim/truth_json.h"

namespace magimu::apps {
namespace {

struct SimulateArguments {
  std::string output, truth, motion = "paper", like, model;
  std::vector<double> noise;
  std::vector<std::string> effects;
  std::optional<std::uint64_t> device;
  bool quiet = false;
  int threads = 0;  // as every command takes it; making a recording needs one
  SimulationOptions options;
};

int run(SimulateArguments& args) {
  check_outputs({args.like, args.model}, {args.output, args.truth});
  for (const SimulatedMotion m :
       {SimulatedMotion::kHand, SimulatedMotion::kHandHeld, SimulatedMotion::kSequence}) {
    if (args.motion == to_string(m)) args.options.motion = m;
  }
  if (args.device) {
    args.options.device = draw_parameters(*args.device, args.options.magnetometers);
  }
  if (!args.noise.empty()) args.options.noise = {args.noise[0], args.noise[1], args.noise[2]};
  for (const std::string& text : args.effects) {
    args.options.effects.push_back(parse_effect_request(text));
  }
  std::vector<std::string> notes;
  if (!args.like.empty()) {
    make_replica(read_with(args.like, {}, args.quiet), args.model, args.options, notes);
    args.motion = "the same";
  }
  for (const std::string& note : notes) {
    if (!args.quiet) fmt::print(stderr, "magimu: {}\n", note);
  }
  const Simulation s = with_bar(!args.quiet, "simulating " + args.output, [&] {
    Simulation out = simulate(args.options);
    write_csv(out.recording, args.output);
    return out;
  });
  if (!args.truth.empty()) {
    write_atomically(args.truth, to_json(s.truth, args.options).dump(2) + "\n");
  }
  if (!args.quiet) {
    std::FILE* const where = where_words_go(args.output);
    fmt::print(where, "{}: {:.0f} s of {} motion at {:g} Hz, {} samples, seed {}\n", args.output,
               s.recording.duration_s(),
               s.truth.p.empty() || !args.like.empty() ? args.motion : "hand_held",
               args.options.rate_hz, s.recording.gyr.size(), args.options.seed);
    for (const HiddenEffect& effect : s.truth.effects) {
      std::string values;
      for (const auto& p : effect.parameters) {
        values += fmt::format(" {} = {:.4g}{}{}", p.name, p.value, p.unit == "1" ? "" : " ",
                              p.unit == "1" ? "" : p.unit);
      }
      fmt::print(where, "  {}:{}\n", effect.name, values);
    }
  }
  return kDone;
}

}  // namespace

void add_simulate(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<SimulateArguments>();
  args->options.gravity = kStandardGravity;  // as calibrate assumes; the paper's study has 9.8
  CLI::App* cmd = app.add_subcommand("simulate", "Make a recording whose truth is known");
  cmd->footer(
      "Example: magimu simulate -o rec.csv --truth truth.json --motion hand --rate 100\n"
      "What would the model have measured: magimu simulate --like rec.csv --model diag.json -o "
      "replica.csv");
  add_output(*cmd, "-o,--output", args->output, "the recording", "REC.csv")->required();
  add_output(*cmd, "--truth", args->truth, "write the true parameters here", "T.json");
  cmd->add_option("--seed", args->options.seed, "names the data set")->capture_default_str();
  cmd->add_option("--device", args->device,
                  "the device and its place are those of this seed; --seed names motion and noise: "
                  "several recordings of one device (none: all by --seed)")
      ->type_name("SEED");
  cmd->add_option("--rate", args->options.rate_hz, "IMU samples a second")
      ->capture_default_str()
      ->type_name("HZ");
  cmd->add_option("--mag-ratio", args->options.mag_ratio, "IMU samples per magnetometer sample")
      ->capture_default_str()
      ->type_name("N");
  cmd->add_option("--motion", args->motion,
                  "paper: six slow turns; hand: turned in the hands, with rests; hand_held: moved "
                  "about, too; sequence: the half turns that the paper recommends")
      ->capture_default_str()
      ->check(CLI::IsMember({"paper", "hand", "hand_held", "sequence"}));
  cmd->add_option("--displacement", args->options.displacement_m,
                  "how far hand_held moves, RMS (-1: drawn from 0.05 to 0.30)")
      ->capture_default_str()
      ->type_name("M");
  cmd->add_option("--speed", args->options.speed_mps,
                  "how fast whoever holds it walks, drives or flies, RMS, with hand_held")
      ->check(nonnegative_number())
      ->capture_default_str()
      ->type_name("M/S");
  cmd->add_option("--duration", args->options.duration_s, "seconds (0: the motion's own)")
      ->capture_default_str()
      ->type_name("S");
  cmd->add_option("--rest", args->options.rest_s, "seconds at rest first (-1: the motion's own)")
      ->capture_default_str()
      ->type_name("S");
  cmd->add_option("--noise", args->noise, "noise densities per sqrt(Hz): m/s^2 rad/s uT")
      ->expected(3)
      ->check(nonnegative_number())
      ->type_name("ACC GYR MAG");
  repeatable(
      cmd->add_option("--effect", args->effects,
                      "hide an effect, of a random realistic size by the seed; =2: twice that; "
                      "=0.05:0:0.02: these parameters (0.012: for a single one); repeatable; "
                      "an unknown name lists all")
          ->type_name("NAME[=SIZE]"));
  CLI::Option* const like =
      cmd->add_option(
             "--like", args->like,
             "a replica of this recording: the motion, device and noise that a model finds "
             "in it, and new noise by the seed")
          ->check(CLI::ExistingFile)
          ->type_name("REC");
  for (const char* other : {"--device", "--rate", "--mag-ratio", "--motion", "--displacement",
                            "--speed", "--duration", "--rest", "--noise"}) {
    like->excludes(other);
  }
  cmd->add_option("--model", args->model,
                  "with --like: the model that `magimu diagnose` arrived at (none: the one without "
                  "causes)")
      ->needs(like)
      ->check(CLI::ExistingFile)
      ->type_name("DIAG.json");
  cmd->add_option("--room", args->options.room,
                  "with --motion hand_held: a room with iron beyond its walls, a steel table and a "
                  "tram that passes, named by this seed (none: the same field everywhere)")
      ->type_name("SEED");
  cmd->add_option("--magnetometers", args->options.magnetometers, "how many, on one board")
      ->capture_default_str()
      ->type_name("N");
  cmd->add_option("--gravity", args->options.gravity, "m/s^2; the paper's study has 9.8")
      ->capture_default_str()
      ->type_name("G");
  cmd->add_option("--threads", args->threads, "as in other commands; one is used")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd->add_flag("-q,--quiet", args->quiet, "print nothing but errors");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
