// SPDX-License-Identifier: BSD-3-Clause
// What streaming calibration costs, and whether it ends where it should.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>

#include "bench/error_statistics.h"
#include "bench/streamed.h"

namespace magimu {
namespace {

int print(const Recording& recording, const StreamingOptions& options) {
  StreamingCalibration stream(int(recording.mag.size()), options);
  for (const StreamSample& s : samples_of(recording)) {
    const auto start = std::chrono::steady_clock::now();
    const auto u = stream.add(s);
    const double us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
    if (!u) continue;
    fmt::print("{:7.2f} {:12} {:8.0f} us", u->t, to_string(u->phase), us);
    if (u->theta) {
      fmt::print(
          "  heading {:.3f} deg  o_m {:.3f} {:.3f} {:.3f} +- {:.3f}  nis {:.0f}/{} p {:.2g}{}",
          heading_sigma_deg(*u->theta), u->theta->parameters.mag[0].bias[0],
          u->theta->parameters.mag[0].bias[1], u->theta->parameters.mag[0].bias[2],
          u->theta->sigma("magnetometers[0].bias[0]"), u->window.nis, u->window.dof,
          u->window.p_value, u->window.used ? "" : " OUT");
    }
    fmt::print("  {}\n", u->guidance);
    for (const std::string& e : u->events) fmt::print("          * {}\n", e);
  }
  stream.settle();
  const auto last = stream.estimate();
  const Calibration c = stream.finish();
  if (last) {
    const VectorXd d = in_calibration_order(c) - in_calibration_order(*last);
    fmt::print(
        "end: {} {}; {:.2g} sigma from the fit of all; trust {}\n", c.order.size(), c.fit.message,
        (d.array().abs() / c.covariance_model.diagonal().head(d.size()).array().sqrt()).maxCoeff(),
        to_string(c.trust.verdict));
    for (const auto& r : c.trust.reasons) fmt::print("  {}\n", r);
    for (const auto& r : c.checks) fmt::print("  {}\n", r.sentence);
  }
  return 0;
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  CLI::App app("Streaming calibration, measured");
  std::string motion = "hand", file, model = "auto", mode = "print";
  std::uint64_t seed = 1;
  double rate = 80.0, duration = 0.0;
  bool noise = false;
  app.add_option("mode", mode);
  app.add_option("--motion", motion);
  app.add_option("--file", file);
  app.add_option("--model", model);
  app.add_option("--seed", seed);
  app.add_option("--rate", rate);
  app.add_option("--duration", duration);
  app.add_flag("--noise-given", noise);
  CLI11_PARSE(app, argc, argv);
  StreamingOptions options;
  options.motion = model == "rotation"    ? MotionModel::kRotation
                   : model == "hand_held" ? MotionModel::kHandHeld
                                          : MotionModel::kAuto;
  Recording recording;
  if (file.empty()) {
    SimulationOptions simulated;
    simulated.motion = motion == "paper"       ? SimulatedMotion::kPaper
                       : motion == "hand_held" ? SimulatedMotion::kHandHeld
                                               : SimulatedMotion::kHand;
    simulated.rate_hz = rate;
    simulated.seed = seed;
    simulated.duration_s = duration;
    const Simulation s = simulate(simulated);
    recording = s.recording;
    options.gravity = s.truth.gravity;
    if (noise) options.noise = s.truth.noise;
  } else {
    recording = read_recording(file);
  }
  return print(recording, options);
}
