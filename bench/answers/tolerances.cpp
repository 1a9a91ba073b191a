// SPDX-License-Identifier: BSD-3-Clause
// Do the sigmas hold where parts are as their data sheets say and the motion does not show it? A
// sensor that stays level (within 10 deg: a boat; within 30 deg: a phone waved in figures of eight;
// within 3 deg: a car or a robot) and one that is turned to all sides; nothing hidden, or a random
// error of accelerometer or gyroscope of each family at 1 times its usual size. The oracle's
// recordings are calibrated with nothing told, noise included.
//   bench_tolerances [--runs 20] [--first-seed 1] [--size 0.5] [--motion NAME] [--hidden NAME]
//                    [--save DIR]
// --size: of gains and axes, %; the gyroscope's g-sensitivity is --size times 0.2 deg/s/g. --save:
// writes recordings (CSV) and truths (19 numbers in the order of a calibration) and calibrates
// none. A line a motion and an error: verdicts; of those that are not `no` the NEES over 19, in the
// median and on average; RMS and largest |error| / sigma of the accelerometer's and the gyroscope's
// bias, D, o_m and dip; the median sigma of both biases.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <array>
#include <fstream>
#include <string>
#include <vector>

#include "bench/power/true_parameters.h"
#include "calibration/calibrate.h"
#include "recording/csv/csv.h"
#include "statistics/quantiles.h"
#include "study/error_statistics.h"
#include "tests/oracle/random.h"
#include "tests/oracle/sensors.h"

namespace {

using namespace magimu;

struct Arguments {
  int runs = 20, first_seed = 1;
  double size = 0.5;
  std::string motion, hidden, save;
};

struct Motion {
  const char* name;
  oracle::MotionKind kind;
  double farthest_deg;
};
constexpr Motion kMotions[] = {
    {"car", oracle::MotionKind::kLevel, 3.0},     {"boat", oracle::MotionKind::kLevel, 10.0},
    {"eight", oracle::MotionKind::kLevel, 30.0},  {"short", oracle::MotionKind::kShortTurn, 35.0},
    {"rich", oracle::MotionKind::kRotation, 0.0}, {"held", oracle::MotionKind::kHandHeld, 0.0}};
constexpr const char* kHidden[] = {"none", "gain", "axes", "turned", "g", "all"};

std::vector<double> drawn(oracle::Random& random, int n, double sigma) {
  std::vector<double> out;
  for (int i = 0; i < n; ++i) out.push_back(sigma * random.normal());
  return out;
}

// gain: of the accelerometer's axes; axes: not square; turned: against the gyroscope's.
std::vector<oracle::Effect> effects_of(const std::string& hidden, double percent, int seed) {
  oracle::Random random(std::uint64_t(seed), oracle::Stream::kEffectSize, 1);
  const double s = 0.01 * percent, g = percent * 0.2 * oracle::kDegree / 9.80665;
  const bool all = hidden == "all";
  std::vector<oracle::Effect> out;
  std::vector<double> L = drawn(random, 6, s);  // 11, 21, 22, 31, 32, 33
  if (hidden == "gain") L[1] = L[3] = L[4] = 0.0;
  if (hidden == "axes") L[0] = L[2] = L[5] = 0.0;
  if (all || hidden == "gain" || hidden == "axes") {
    out.push_back(oracle::make_effect("acc_scale_misalignment", L));
  }
  std::vector<double> S = drawn(random, 9, s);
  if (hidden == "turned") {
    S = {0, S[1], S[2], -S[1], 0, S[5], -S[2], -S[5], 0};
  }
  if (all || hidden == "turned") {
    out.push_back(oracle::make_effect("gyro_scale_misalignment", S));
  }
  if (all || hidden == "g") {
    out.push_back(oracle::make_effect("gyro_g_sensitivity", drawn(random, 9, g)));
  }
  return out;
}

oracle::Simulation simulated(const Motion& motion, const std::string& hidden, double percent,
                             int seed) {
  oracle::Options o;
  o.seed = std::uint64_t(seed);
  o.rate_hz = 50.0;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.noise = oracle::kRealisticDensities;
  o.motion.kind = motion.kind;
  o.motion.duration_s = 120.0;
  o.motion.fastest_rad_s = 2.0;
  o.motion.farthest_turn_deg = motion.farthest_deg;
  o.effects = effects_of(hidden, percent, seed);
  return oracle::simulate(o);
}

struct Line {
  int yes = 0, limited = 0, no = 0, outside = 0;
  std::vector<double> nees, sigma_acc, sigma_gyr;
  std::array<std::vector<double>, 5> z;

  void add(const Calibration& c, const VectorXd& truth) {
    constexpr double kQuantile = 43.820;  // chi-square of 19, 99.9 %
    yes += c.trust.verdict == Verdict::kYes;
    limited += c.trust.verdict == Verdict::kLimited;
    no += c.trust.verdict == Verdict::kNo;
    if (c.trust.verdict == Verdict::kNo) return;
    const MatrixXd V = c.covariance.topLeftCorner(19, 19);
    const VectorXd e = in_calibration_order(c).head(19) - truth;
    nees.push_back(e.dot(V.ldlt().solve(e)) / 19.0);
    outside += c.trust.verdict == Verdict::kYes && !(19.0 * nees.back() < kQuantile);
    const VectorXd sigma = V.diagonal().cwiseSqrt();
    constexpr int kFirst[] = {0, 3, 6, 15, 18, 19};
    for (int group = 0; group < 5; ++group) {
      for (int i = kFirst[group]; i < kFirst[group + 1]; ++i) {
        z[std::size_t(group)].push_back(std::abs(e[i]) / sigma[i]);
      }
    }
    sigma_acc.push_back(sigma.head<3>().norm());
    sigma_gyr.push_back(sigma.segment<3>(3).norm());
  }
  void print(const std::string& name) const {
    fmt::print("{:<14} {:>3} {:>3} {:>3} {:>4} ", name, yes, limited, no, outside);
    if (nees.empty()) return fmt::print("\n");
    double mean = 0.0;
    for (const double x : nees) mean += x / double(nees.size());
    fmt::print("{:>8.2f} {:>8.2f}  ", quantile(nees, 0.5), mean);
    for (const std::vector<double>& group : z) {
      double squares = 0.0, most = 0.0;
      for (const double x : group) squares += x * x / double(group.size());
      for (const double x : group) most = std::max(most, x);
      fmt::print("{:>6.2f} {:>5.1f} ", std::sqrt(squares), most);
    }
    fmt::print(" {:.4g} {:.3g}\n", quantile(sigma_acc, 0.5), quantile(sigma_gyr, 0.5));
    std::fflush(stdout);
  }
};

void save(const Arguments& args, const std::string& name, const oracle::Simulation& s) {
  write_csv(s.recording, args.save + "/" + name + ".csv");
  const SensorParameters p = true_parameters(s.truth.device);
  std::ofstream out(args.save + "/" + name + ".truth");
  const VectorXd all = in_calibration_order(p, {p.dip_rad});
  for (const double x : all) out << fmt::format("{:.17g}\n", x);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Do the sigmas hold where parts are as data sheets say?");
  Arguments args;
  app.add_option("--runs", args.runs);
  app.add_option("--first-seed", args.first_seed);
  app.add_option("--size", args.size);
  app.add_option("--motion", args.motion);
  app.add_option("--hidden", args.hidden);
  app.add_option("--save", args.save);
  CLI11_PARSE(app, argc, argv);
  fmt::print("{:<14} {:>3} {:>3} {:>3} {:>4} {:>8} {:>8}  {:^12} {:^12} {:^12} {:^12} {:^12} {}\n",
             "", "yes", "lim", "no", "out", "NEES med", "mean", "o_a", "o_w", "D", "o_m", "dip",
             "sigma o_a, o_w");
  for (const Motion& motion : kMotions) {
    if (!args.motion.empty() && args.motion != motion.name) continue;
    for (const std::string hidden : kHidden) {
      if (!args.hidden.empty() && args.hidden != hidden) continue;
      Line line;
      for (int i = 0; i < args.runs; ++i) {
        const int seed = args.first_seed + i;
        const oracle::Simulation s = simulated(motion, hidden, args.size, seed);
        const std::string name = fmt::format("{}_{}", motion.name, hidden);
        if (!args.save.empty()) {
          save(args, fmt::format("{}_{}", name, seed), s);
          continue;
        }
        const SensorParameters p = true_parameters(s.truth.device);
        line.add(calibrate(s.recording), in_calibration_order(p, {p.dip_rad}));
      }
      line.print(fmt::format("{} {}", motion.name, hidden));
    }
  }
}
