// SPDX-License-Identifier: BSD-3-Clause
// Can the evidence of what a model lacks be trusted? Three tables:
//
//   bench_evidence null [-n N] [--motion hand|hand_held|paper] [--rate HZ]
//       G of each process on simulated recordings with nothing wrong: how often 0, its quantiles
//   bench_evidence hidden
//       what is hidden in a simulation -> G of each process: which sensor it is seen in
//   bench_evidence real RECORDING...
//       a diagnosis of each: G of each process, before and after what was named, and the answer
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <functional>

#include "calibration/fit/disturbances/disturbance.h"
#include "calibration/pipeline.h"
#include "diagnosis/noise/thinned.h"
#include "diagnosis/result/diagnosis.h"
#include "recording/read.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

struct Case {
  SimulatedMotion motion = SimulatedMotion::kHand;
  double rate_hz = 80.0, duration_s = 120.0;
  std::uint64_t seed = 1;
  std::vector<std::string> effects;
  std::function<void(Recording&)> change;
  bool noise_known = true, always = false;
};

using Fits = std::vector<DisturbanceFit>;

// Of the basic model for this motion.
Fits fits_of(const Case& c) {
  SimulationOptions o;
  o.motion = c.motion;
  o.rate_hz = c.rate_hz;
  o.duration_s = c.duration_s;
  o.seed = c.seed;
  for (const std::string& e : c.effects) o.effects.push_back(parse_effect_request(e));
  Simulation simulation = simulate(o);
  if (c.change) c.change(simulation.recording);
  const Recording thin = thinned(simulation.recording);
  const CheckedRecordings checked({&thin});
  CalibrationOptions options;
  if (c.noise_known) options.noise = o.noise;
  options.gravity = o.gravity;
  const Pipeline pipeline(checked.get(), options);
  const Stage stage = pipeline.coarse_fit(
      c.motion == SimulatedMotion::kHandHeld ? MotionModel::kHandHeld : MotionModel::kRotation);
  DisturbanceOptions d;
  d.mag_noise_known = c.noise_known;
  if (c.always) d.least_gain = -1.0;
  Fits out;
  for (const DisturbedPart part : kDisturbedParts) {
    out.push_back(DisturbanceModel(stage, part, d).fit());
  }
  return out;
}

std::string name_of(DisturbedPart part) {
  return part == DisturbedPart::kField ? "field" : to_string(sensor_of(part));
}

SimulatedMotion motion_of(const std::string& name) {
  if (name == "paper") return SimulatedMotion::kPaper;
  return name == "hand_held" ? SimulatedMotion::kHandHeld : SimulatedMotion::kHand;
}

void null_table(const Case& like, int n) {
  std::vector<Fits> all(std::size_t(n), Fits{});
  tbb::parallel_for(0, n, [&](int i) {
    Case c = like;
    c.seed = like.seed + std::uint64_t(i);
    try {
      all[std::size_t(i)] = fits_of(c);
    } catch (const std::exception& error) {
      fmt::print(stderr, "seed {}: {}\n", c.seed, error.what());
    }
  });
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const DisturbanceFit& f : all[i]) {
      if (f.gain_nats <= kNullGain) continue;
      fmt::print("seed {}: {} gains {:.2f} nats, size {:.3g} {}, memory {:.3g} s, score {:.1f}\n",
                 like.seed + i, name_of(f.part), f.gain_nats, f.size, unit_of(sensor_of(f.part)),
                 f.memory_s, f.score);
    }
  }
  std::erase_if(all, [](const Fits& f) { return f.empty(); });
  fmt::print("{} recordings at {} Hz, {} s\n", all.size(), like.rate_hz, like.duration_s);
  fmt::print("{:8}{:>9}{:>8}{:>8}{:>8}{:>8}{:>8}{:>10}{:>8}\n", "process", "G = 0", "median",
             "80 %", "95 %", "99 %", "largest", "over 6", "sweeps");
  for (std::size_t p = 0; p < std::size(kDisturbedParts); ++p) {
    std::vector<double> g;
    double sweeps = 0.0;
    for (const Fits& f : all) {
      g.push_back(f[p].gain_nats);
      sweeps += f[p].sweeps;
    }
    std::ranges::sort(g);
    const auto quantile = [&](double share) {
      return g[std::min(g.size() - 1, std::size_t(share * double(g.size())))];
    };
    const auto count = [&](double below) {
      return double(std::ranges::count_if(g, [&](double x) { return x <= below; }));
    };
    fmt::print("{:8}{:8.1f}%{:8.2f}{:8.2f}{:8.2f}{:8.2f}{:8.2f}{:9.2f}%{:8.0f}\n",
               name_of(kDisturbedParts[p]), 100.0 * count(0.01) / double(g.size()), quantile(0.5),
               quantile(0.8), quantile(0.95), quantile(0.99), g.back(),
               100.0 * (1.0 - count(kNullGain) / double(g.size())), sweeps / double(g.size()));
  }
}

// From the middle of the recording on.
template <class F>
std::function<void(Recording&)> later(VectorSeries Recording::*series, const F& f) {
  return [=](Recording& r) {
    VectorSeries& s = r.*series;
    for (std::size_t k = s.size() / 2; k < s.size(); ++k) f(s.v[k]);
  };
}
template <class F>
std::function<void(Recording&)> later_mag(const F& f) {
  return [=](Recording& r) {
    VectorSeries& s = r.mag.front();
    for (std::size_t k = s.size() / 2; k < s.size(); ++k) f(s.v[k]);
  };
}

void hidden_table(const Case& like) {
  const std::vector<
      std::tuple<std::string, std::vector<std::string>, std::function<void(Recording&)>>>
      cases = {
          {"nothing", {}, {}},
          {"magnetometer x gain 0.2 %", {}, later_mag([](Vector3& v) { v[0] *= 1.002; })},
          {"magnetometer x gain 1 %", {}, later_mag([](Vector3& v) { v[0] *= 1.01; })},
          {"hard iron 1.5 uT", {}, later_mag([](Vector3& v) { v[1] += 1.5; })},
          {"magnetometer turns 0.3 deg", {}, later_mag([](Vector3& v) {
             v = Rot3::Exp(Vector3(0.0, 0.0, 0.3 * kDegree)) * v;
           })},
          {"gyroscope gain 1 %", {}, later(&Recording::gyr, [](Vector3& v) { v *= 1.01; })},
          {"gyroscope z gain 0.2 %", {}, later(&Recording::gyr, [](Vector3& v) { v[2] *= 1.002; })},
          {"accelerometer x gain 1 %",
           {},
           later(&Recording::acc, [](Vector3& v) { v[0] *= 1.01; })},
          {"field drifts", {"field_drift"}, {}},
          {"hard iron drifts", {"hard_iron_drift"}, {}},
          {"gyroscope bias walks", {"gyro_bias_drift"}, {}},
          {"gyroscope matrix", {"gyro_scale_misalignment"}, {}},
          {"accelerometer matrix", {"acc_scale_misalignment"}, {}},
          {"magnetometer lags", {"mag_lag"}, {}},
          {"magnetometer nonlinear", {"mag_nonlinearity"}, {}},
          {"magnetometer noise coloured", {"correlated_noise"}, {}},
          {"accelerometer 5 ms late",
           {},
           [](Recording& r) {
             for (double& t : r.acc.t) t += 0.005;
           }},
      };
  std::vector<Fits> all(cases.size());
  tbb::parallel_for(std::size_t(0), cases.size(), [&](std::size_t i) {
    Case c = like;
    c.effects = std::get<1>(cases[i]);
    c.change = std::get<2>(cases[i]);
    c.noise_known = false;
    all[i] = fits_of(c);
  });
  fmt::print("{:30}{:>12}{:>12}{:>12}{:>12}   nats\n", "hidden", "field", "mag", "gyr", "acc");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    fmt::print("{:30}", std::get<0>(cases[i]));
    for (const DisturbanceFit& f : all[i]) fmt::print("{:12.1f}", f.gain_nats);
    fmt::print("\n");
  }
}

void real_table(const std::vector<std::string>& files) {
  fmt::print("{:28}{:>11}{:>7}   {}\n", "recording", "answer", "s",
             "field / mag / gyr / acc: nats (left), memory s");
  for (const std::string& file : files) {
    const Recording recording = read_recording(file);
    const Diagnosis d = diagnose(recording);
    fmt::print("{:28}{:>11}{:7.1f}", recording.name, to_string(d.answer), d.seconds);
    for (const MissingState& m : d.missing) {
      fmt::print("  {:.0f} ({:.0f}) {:.2g}", m.gain_nats, m.left_nats, m.memory_s);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  CLI::App app("Evidence of what a model lacks: its null distribution, and what it sees");
  app.require_subcommand(1);
  Case like;
  int n = 200;
  std::string motion = "hand";
  std::vector<std::string> files;
  CLI::App* null = app.add_subcommand("null", "nothing hidden");
  CLI::App* hidden = app.add_subcommand("hidden", "one thing hidden after the other");
  for (CLI::App* command : {null, hidden}) {
    command->add_option("--motion", motion, "hand, hand_held or paper");
    command->add_option("--rate", like.rate_hz, "Hz");
    command->add_option("--duration", like.duration_s, "s");
    command->add_option("--seed", like.seed, "of the first recording");
  }
  null->add_option("-n", n, "recordings");
  null->add_flag("--always", like.always, "fit each process, whatever the score says");
  CLI::App* real = app.add_subcommand("real", "diagnoses of recordings");
  real->add_option("files", files, "recordings")->required();
  CLI11_PARSE(app, argc, argv);
  like.motion = motion_of(motion);
  if (null->parsed()) null_table(like, n);
  if (hidden->parsed()) hidden_table(like);
  if (real->parsed()) real_table(files);
}
