// SPDX-License-Identifier: BSD-3-Clause
// Random undamaged recordings: fault_bases.h.
#include "bench/faults/fault_bases.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "bench/dice.h"
#include "bench/power/hidden_cases.h"
#include "recording/read.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kPaperTurns = 325.0;  // s: every axis of the paper's motion once
constexpr double kRichSeconds = 60.0;
const std::vector<double> kRates = {20,  25,  40,  50,  62.5, 80,  100, 104,
                                    125, 160, 200, 208, 250,  400, 500, 1000};

// A logger's decimals, fine enough that rounding is less than half a standard deviation of the
// noise: coarser ones are a fault of its own.
int digits_for(double sigma) { return std::max(2, int(std::ceil(-std::log10(sigma)))); }

void write_like_a_logger(Base& base, Dice& dice) {
  if (dice.chance(0.5)) return;
  const double root = std::sqrt(base.rate_hz);
  for (int s = 0; s < base.log.sensors(); ++s) {
    const double density = s == 0 ? base.noise.acc : s == 1 ? base.noise.gyr : base.noise.mag;
    base.log.digits[std::size_t(s)] = digits_for(density * root);
  }
  base.log.time_digits = 6;
}

// So many samples are quick to calibrate.
double duration(const BaseWishes& wishes, double rate_hz, Dice& dice) {
  const double longest = (wishes.small ? 4000.0 : 30000.0) / rate_hz;
  const double wanted = dice.chance(0.15) ? dice.uniform(20.0, 60.0) : dice.uniform(60.0, 120.0);
  return std::round(std::clamp(longest, 20.0, wanted));
}

Base by_sim(std::uint64_t seed, const BaseWishes& wishes, Dice& dice) {
  SimulationOptions o;
  o.seed = seed;
  o.gravity = kGravity;
  const bool paper = !wishes.small && dice.chance(0.25);
  o.motion = paper              ? SimulatedMotion::kPaper
             : dice.chance(0.5) ? SimulatedMotion::kHand
                                : SimulatedMotion::kHandHeld;
  o.rate_hz = paper ? dice.pick<double>({20, 40, 50, 80}) : dice.pick(kRates);
  if (wishes.small) o.rate_hz = std::min(o.rate_hz, 50.0);
  o.duration_s = paper ? kPaperTurns : duration(wishes, o.rate_hz, dice);
  o.mag_ratio = dice.chance(0.7) || o.rate_hz < 40.0 ? 1 : dice.pick<int>({2, 4});
  if (o.rate_hz > 300.0 && dice.chance(0.5)) o.mag_ratio = 10;
  if (dice.chance(0.1)) o.magnetometers = 3;
  Base base;
  const Simulation simulation = simulate(o);
  base.source = "sim";
  base.motion = to_string(o.motion);
  base.rate_hz = o.rate_hz;
  base.duration_s = o.duration_s;
  base.rich = o.duration_s >= kRichSeconds;
  base.log = log_of(simulation.recording);
  base.truth = simulation.truth.parameters;
  const NoiseDensities& noise = simulation.truth.noise;
  base.noise = {noise.acc, noise.gyr, noise.mag};
  return base;
}

Base by_oracle(std::uint64_t seed, const BaseWishes& wishes, Dice& dice) {
  oracle::Options o;
  o.seed = seed;
  o.rate_hz = wishes.small ? dice.pick<double>({25, 40, 50}) : dice.pick(kRates);
  o.motion.kind = dice.chance(0.5) ? oracle::MotionKind::kRotation : oracle::MotionKind::kHandHeld;
  o.motion.duration_s = duration(wishes, o.rate_hz, dice);
  o.motion.fastest_rad_s = dice.uniform(1.5, 3.0);
  o.motion.displacement_m = dice.uniform(0.04, 0.12);
  o.motion.band_hz[1] = 1.0;
  o.device_kind = dice.chance(0.5) ? oracle::DeviceKind::kBoard : oracle::DeviceKind::kTableI;
  o.noise = dice.chance(0.5) ? oracle::kRealisticDensities : oracle::kTableIDensities;
  // As fast as the IMU, slower by a round ratio or by none, or faster.
  const double ratio = dice.pick<double>({1.0, 1.0, 1.0, 0.5, 0.25, 0.77, 2.0});
  if (ratio != 1.0 && o.rate_hz * ratio >= 10.0) o.mag_rate_hz = o.rate_hz * ratio;
  Base base;
  const oracle::Simulation simulation = oracle::simulate(o);
  base.source = "oracle";
  base.motion = oracle::to_string(o.motion.kind);
  base.rate_hz = o.rate_hz;
  base.duration_s = o.motion.duration_s;
  base.rich = base.duration_s >= kRichSeconds;
  base.log = log_of(simulation.recording);
  base.truth = true_parameters(simulation.truth.device);
  base.noise = o.noise;
  return base;
}

VectorSeries every(const VectorSeries& series, std::size_t n) {
  VectorSeries kept;
  for (std::size_t k = 0; k < series.size(); k += n) kept.push_back(series.t[k], series.v[k]);
  return kept;
}

std::vector<std::filesystem::path> real_files(const std::string& data_dir) {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path folder = std::filesystem::path(data_dir) / "broad";
  if (data_dir.empty() || !std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// 30 to 60 s out of the middle; every n-th sample, as a slower logger would have them.
Base by_hand(std::uint64_t, const std::vector<std::filesystem::path>& files, Dice& dice) {
  const std::filesystem::path& file = dice.pick(files);
  Recording whole = read_recording(file.string());
  whole.gyr.t = whole.acc.t;  // one time a row, as loggers write
  const double length = dice.uniform(30.0, 60.0);
  const double room = std::max(0.0, whole.duration_s() - length);
  const double begin = whole.acc.t.front() + room * dice.uniform(0.2, 0.8);
  Recording piece = slice(whole, begin, begin + length);
  const std::size_t n = 1 + dice.index(6);
  Base base;
  base.source = file.stem().string();
  base.motion = "real";
  base.rate_hz = piece.acc.rate_hz() / double(n);
  base.duration_s = length;
  piece.acc = every(piece.acc, n);
  piece.gyr = every(piece.gyr, n);
  for (VectorSeries& mag : piece.mag) mag = every(mag, n);
  for (VectorSeries* s : {&piece.acc, &piece.gyr, &piece.mag.front()}) {
    for (double& t : s->t) t -= begin;
  }
  base.log = log_of(piece);
  base.noise = oracle::kRealisticDensities;
  return base;
}

}  // namespace

Base draw_base(std::uint64_t seed, const BaseWishes& wishes) {
  Dice dice(seed, "base");
  const std::vector<std::filesystem::path> files = real_files(wishes.data_dir);
  const double u = dice.uniform();
  Base base = u < 0.15 && wishes.real && !files.empty() ? by_hand(seed, files, dice)
              : u < 0.55                                ? by_sim(seed, wishes, dice)
                                                        : by_oracle(seed, wishes, dice);
  base.seed = seed;
  write_like_a_logger(base, dice);
  return base;
}

Log with_motion(const Base& base, oracle::MotionKind motion) {
  oracle::Options o;
  o.seed = base.seed;
  o.rate_hz = base.rate_hz;
  o.motion.kind = motion;
  o.motion.duration_s = base.duration_s;
  o.noise = base.noise;
  oracle::Device device;
  device.acc_bias = base.truth->acc_bias;
  device.gyr_bias = base.truth->gyr_bias;
  device.distortion = base.truth->mag.front().distortion;
  device.mag_bias = base.truth->mag.front().bias;
  device.dip_rad = base.truth->dip_rad;
  o.device = device;
  Log log = log_of(oracle::simulate(o).recording);
  log.names[2] = base.log.names[2];
  log.digits.assign(base.log.digits.begin(), base.log.digits.begin() + 3);
  log.time_digits = base.log.time_digits;
  return log;
}

}  // namespace magimu
