// SPDX-License-Identifier: BSD-3-Clause
// Is a `yes` to be believed? Recordings with and without something hidden in them (every effect of
// docs/effects.md and some outside of it, poor motions, disturbances, from the tests' oracle) are
// calibrated with nothing told, noise included; a verdict of yes is wrong where the true parameters
// lie outside of the 99.9 % ellipsoid of the reported covariance.
//   bench_verdicts [--runs 500] [--first-seed 1] [--threads 0] [--list] [--save REC.csv]
// Two in five recordings have nothing hidden and a rich motion: there the verdict should be yes.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <atomic>
#include <chrono>
#include <cstring>
#include <map>
#include <string>
#include <thread>

#include "bench/power/true_parameters.h"
#include "calibration/calibrate.h"
#include "recording/csv/csv.h"
#include "recording/data/error.h"
#include "study/error_statistics.h"
#include "tests/oracle/sensors.h"

namespace {

using namespace magimu;

struct Arguments {
  int runs = 500, first_seed = 1, threads = 0;
  bool list = false;
  std::string save;  // write the first recording here, too
};

struct Case {
  std::string hidden = "nothing";  // effect, or the motion where that is what is poor
  oracle::Options options;
};

struct Outcome {
  std::string hidden, motion, model, reason;
  Verdict verdict = Verdict::kNo;
  double distance = 0.0;  // e' V^-1 e of the 19
  bool outside = false;
};

// A number in [0, 1) that belongs to this seed and purpose.
double draw(int seed, int purpose) {
  std::uint64_t x = std::uint64_t(seed) * 0x9E3779B97F4A7C15u + std::uint64_t(purpose);
  for (int i = 0; i < 3; ++i) {
    x ^= x >> 31;
    x *= 0xBF58476D1CE4E5B9u;
  }
  return double(x >> 11) * 0x1p-53;
}

template <class T>
const T& pick(const std::vector<T>& from, double u) {
  return from[std::size_t(u * double(from.size()))];
}

Case make_case(int seed) {
  Case c;
  oracle::Options& o = c.options;
  o.seed = std::uint64_t(seed);
  o.rate_hz = draw(seed, 1) < 0.5 ? 50.0 : 100.0;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.noise = oracle::kRealisticDensities;
  o.motion.duration_s = 80.0 + 60.0 * draw(seed, 2);
  o.motion.fastest_rad_s = 1.0 + 2.0 * draw(seed, 3);
  o.motion.displacement_m = 0.03 + 0.17 * draw(seed, 4);
  o.motion.band_hz[1] = 1.0;
  const bool moved = draw(seed, 5) < 0.5;
  o.motion.kind = moved ? oracle::MotionKind::kHandHeld : oracle::MotionKind::kRotation;
  const double u = draw(seed, 6);
  if (u < 0.4) return c;
  if (u < 0.5) {
    using enum oracle::MotionKind;
    const std::vector<oracle::MotionKind> poor = {kOneAxis, kTranslation, kShortTurn, kStill};
    o.motion.kind = pick(poor, draw(seed, 7));
    c.hidden = oracle::to_string(o.motion.kind);
    return c;
  }
  std::vector<std::string> effects = oracle::catalogue_effects();
  effects.insert(effects.end(), oracle::outside_effects().begin(), oracle::outside_effects().end());
  c.hidden = pick(effects, draw(seed, 8));
  oracle::EffectScale scale;
  scale.strength = std::exp(std::log(0.1) + std::log(30.0) * draw(seed, 9));  // 0.1 to 3
  scale.channel = oracle::Channel(int(3.0 * draw(seed, 10)));
  scale.duration_s = o.motion.duration_s;
  scale.field_uT = 48.0;
  o.effects = {oracle::random_effect(c.hidden, std::uint64_t(seed), scale)};
  return c;
}

Vector3 mean_difference(const VectorSeries& a, const VectorSeries& b) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < a.size(); ++k) sum += a.v[k] - b.v[k];
  return sum / double(std::max<std::size_t>(1, a.size()));
}

// What the sensors had while they were recorded: a bias that drifts has no other value than its
// mean, the constant part of a current's field is hard iron, and the field is that of the place,
// whatever makes it.
SensorParameters parameters_during(const oracle::Options& options, const oracle::Simulation& s) {
  SensorParameters p = true_parameters(s.truth.device);
  const std::string name = options.effects.empty() ? "" : options.effects.front().name();
  const auto is = [&](std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
  };
  const bool of_bias = is({"gyro_bias_drift", "gyro_temperature", "acc_temperature",
                           "mag_temperature", "hard_iron_drift", "mag_current", "cable_field"});
  const bool of_place = is({"stationary_source", "field_gradient", "field_drift"});
  if (!of_bias && !of_place) return p;
  oracle::Options with = options, without = options;
  with.noise_factor = without.noise_factor = 0.0;
  without.effects.clear();
  const Recording a = oracle::simulate(with).recording, b = oracle::simulate(without).recording;
  if (of_bias) {
    p.acc_bias += mean_difference(a.acc, b.acc);
    p.gyr_bias += mean_difference(a.gyr, b.gyr);
    p.mag[0].bias += mean_difference(a.mag.front(), b.mag.front());
    return p;
  }
  // Differences turned into n, as parts of the field; nRb of the truth is at the samples' times.
  const Matrix3 D_inverse = p.mag[0].distortion.inverse();
  Vector3 sum = Vector3::Zero();
  const VectorSeries &x = a.mag.front(), &y = b.mag.front();
  for (std::size_t k = 0; k < x.size(); ++k) {
    sum += a.truth->nRb[k] * Vector3(D_inverse * (x.v[k] - y.v[k]));
  }
  const Vector3 field =
      Vector3(0.0, std::cos(p.dip_rad), -std::sin(p.dip_rad)) + sum / double(x.size());
  p.mag[0].distortion *= field.norm();
  p.dip_rad = std::atan2(-field[2], std::hypot(field[0], field[1]));
  return p;
}

Outcome run_one(int seed, const std::string& save) {
  const Case c = make_case(seed);
  Outcome out;
  out.hidden = c.hidden;
  out.motion = oracle::to_string(c.options.motion.kind);
  const oracle::Simulation s = oracle::simulate(c.options);
  if (!save.empty()) write_csv(s.recording, save);
  try {
    const Calibration calibration = calibrate(s.recording);
    out.verdict = calibration.trust.verdict;
    out.model = to_string(calibration.motion);
    if (!calibration.trust.reasons.empty()) out.reason = calibration.trust.reasons.front();
    const SensorParameters truth = parameters_during(c.options, s);
    const VectorXd e =
        in_calibration_order(calibration).head(19) - in_calibration_order(truth, {truth.dip_rad});
    const MatrixXd V = calibration.covariance.topLeftCorner(19, 19);
    out.distance = e.dot(V.ldlt().solve(e));
    constexpr double kQuantile = 43.820;  // chi-square of 19, 99.9 %
    out.outside = !(out.distance >= 0.0 && out.distance < kQuantile);
  } catch (const InputError& error) {
    out.reason = error.what();
  }
  return out;
}

std::vector<Outcome> run_all(const Arguments& args) {
  std::vector<Outcome> out(std::size_t(args.runs));
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < args.runs; i = next++) {
      out[std::size_t(i)] = run_one(args.first_seed + i, i == 0 ? args.save : "");
    }
  };
  const int count = args.threads > 0 ? args.threads : int(std::thread::hardware_concurrency());
  std::vector<std::thread> threads;
  for (int i = 1; i < count; ++i) threads.emplace_back(work);
  work();
  for (std::thread& t : threads) t.join();
  return out;
}

struct Count {
  int all = 0, yes = 0, limited = 0, no = 0, wrong_yes = 0;
  void add(const Outcome& o) {
    ++all;
    yes += o.verdict == Verdict::kYes;
    limited += o.verdict == Verdict::kLimited;
    no += o.verdict == Verdict::kNo;
    wrong_yes += o.verdict == Verdict::kYes && o.outside;
  }
};

void print(const std::string& name, const Count& c) {
  fmt::print("{:<26} {:>5} {:>5} {:>8} {:>5} {:>10}\n", name, c.all, c.yes, c.limited, c.no,
             c.wrong_yes);
}

bool report(const std::vector<Outcome>& outcomes, const Arguments& args) {
  std::map<std::string, Count> by_hidden;
  Count all, nothing;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Outcome& o = outcomes[i];
    by_hidden[o.hidden].add(o);
    all.add(o);
    if (o.hidden == "nothing") nothing.add(o);
    if (args.list) {
      fmt::print("{:>4} {:<26} {:<11} {:<9} {:<8} {:>10.1f} {} {}\n", args.first_seed + int(i),
                 o.hidden, o.motion, o.model, to_string(o.verdict), o.distance,
                 o.verdict == Verdict::kYes && o.outside ? "WRONG" : "", o.reason);
    }
  }
  fmt::print("{:<26} {:>5} {:>5} {:>8} {:>5} {:>10}\n", "hidden", "runs", "yes", "limited", "no",
             "wrong yes");
  for (const auto& [name, count] : by_hidden) print(name, count);
  print("all", all);
  const double wrong = 100.0 * all.wrong_yes / std::max(1, all.yes);
  const double right = 100.0 * nothing.yes / std::max(1, nothing.all);
  fmt::print(
      "A yes is wrong in {:.1f} % (at most 1); nothing hidden and rich motion: yes in "
      "{:.1f} % (at least 95)\n",
      wrong, right);
  return wrong <= 1.0 && right >= 95.0;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments args;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--list") {
      args.list = true;
    } else if (i + 1 < argc && name == "--save") {
      args.save = argv[++i];
    } else if (i + 1 < argc &&
               (name == "--runs" || name == "--first-seed" || name == "--threads")) {
      int& value = name == "--runs"      ? args.runs
                   : name == "--threads" ? args.threads
                                         : args.first_seed;
      value = std::atoi(argv[++i]);
    } else {
      fmt::print(stderr,
                 "usage: bench_verdicts [--runs 500] [--first-seed 1] [--threads 0] [--list] "
                 "[--save REC.csv]\n");
      return 2;
    }
  }
  const auto start = std::chrono::steady_clock::now();
  const bool good = report(run_all(args), args);
  fmt::print("{:.0f} s in all\n",
             std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return good ? 0 : 1;
}
