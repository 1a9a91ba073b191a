// SPDX-License-Identifier: BSD-3-Clause
// Arrays of many magnetometers (bench/README.md): is each one's noise density found, do its sigmas
// hold, what does it gain beside calibrating each magnetometer by itself, and what does it cost?
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/calibrate.h"
#include "calibration/result/calibration_json.h"
#include "calibration/result/json_text.h"
#include "graph/decompositions.h"
#include "sim/simulate.h"

namespace {

using namespace magimu;

struct Setting {
  int arrays = 10, magnetometers = 30;
  double rate_hz = 62.5, duration_s = 0.0;
  bool one_by_one = false;
};

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024.0;
}

struct Array {
  Simulation simulation;
  std::vector<double> density;  // of each magnetometer, from half to twice the paper's
};

Array make_array(const Setting& s, std::uint64_t seed) {
  SimulationOptions o;
  o.seed = seed;
  o.rate_hz = s.rate_hz;
  o.duration_s = s.duration_s;
  o.magnetometers = s.magnetometers;
  o.noise.mag = 0.0;
  Array out{simulate(o), {}};
  std::mt19937_64 random(1000 + seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> octave(-1.0, 1.0);
  for (VectorSeries& mag : out.simulation.recording.mag) {
    out.density.push_back(kPaperNoise.mag * std::exp2(octave(random)));
    const double sigma = out.density.back() * std::sqrt(s.rate_hz);
    for (Vector3& v : mag.v) v += sigma * Vector3(normal(random), normal(random), normal(random));
  }
  return out;
}

CalibrationOptions options_for(const Array& array) {
  CalibrationOptions options;
  options.gravity = array.simulation.truth.gravity;
  options.prior = PriorKind::kNone;
  return options;
}

VectorXd error_of(const Calibration& c, std::size_t m, const MagnetometerParameters& truth) {
  VectorXd e(12);
  e << (c.parameters.mag[m].distortion - truth.distortion).reshaped(),
      c.parameters.mag[m].bias - truth.bias;
  return e;
}

double nees(const VectorXd& e, const MatrixXd& P) { return e.dot(P.ldlt().solve(e)); }

struct Sums {
  double densities = 0.0, worst_density = 0.0, worst_gyr = 0.0, gyr = 0.0;
  std::vector<double> nees, nees_robust;      // of each magnetometer, summed over arrays
  double joint = 0.0, alone = 0.0;            // squared errors of D and o_m, uT^2
  double seconds = 0.0, seconds_alone = 0.0;  // of the processor
  double bytes = 0.0, bytes_joint = 0.0;
  int n = 0, yes = 0;
};

Recording alone(const Recording& all, std::size_t m) {
  Recording out;
  out.name = all.name;
  out.acc = all.acc;
  out.gyr = all.gyr;
  out.mag = {all.mag[m]};
  out.mag_names = {"mag"};
  return out;
}

void add_array(const Setting& s, std::uint64_t seed, Sums& sums) {
  const Array array = make_array(s, seed);
  const SensorParameters& truth = array.simulation.truth.parameters;
  const double before = processor_seconds();
  const Calibration c = calibrate(array.simulation.recording, options_for(array));
  sums.bytes = std::max(sums.bytes, double(json_text(to_json(c)).size()));
  sums.seconds += processor_seconds() - before;
  sums.bytes_joint = std::max(sums.bytes_joint, double(json_text(to_json(c, true)).size()));
  sums.yes += c.trust.verdict == Verdict::kYes ? 1 : 0;
  const double gyr = c.noise.gyr / array.simulation.truth.noise.gyr - 1.0;
  sums.gyr += gyr;
  sums.worst_gyr = std::max(sums.worst_gyr, std::abs(gyr));
  sums.nees.resize(truth.mag.size(), 0.0);
  sums.nees_robust.resize(truth.mag.size(), 0.0);
  for (std::size_t m = 0; m < truth.mag.size(); ++m) {
    const double density = c.magnetometers[m].noise / array.density[m] - 1.0;
    sums.densities += density;
    sums.worst_density = std::max(sums.worst_density, std::abs(density));
    const VectorXd e = error_of(c, m, truth.mag[m]);
    const Eigen::Index first = 6 + 12 * Eigen::Index(m);
    sums.nees[m] += nees(e, c.covariance_model.block(first, first, 12, 12));
    sums.nees_robust[m] += nees(e, c.covariance.block(first, first, 12, 12));
    sums.joint += e.squaredNorm();
    if (!s.one_by_one) continue;
    const double start = processor_seconds();
    const Recording pair = alone(array.simulation.recording, m);
    const Calibration own = calibrate(pair, options_for(array));
    sums.seconds_alone += processor_seconds() - start;
    sums.alone += error_of(own, 0, truth.mag[m]).squaredNorm();
  }
  ++sums.n;
}

void print(const Setting& s, const Sums& sums) {
  const double n = sums.n, sensors = n * s.magnetometers;
  const auto [least, most] = std::ranges::minmax(sums.nees);
  const auto [least_robust, most_robust] = std::ranges::minmax(sums.nees_robust);
  // Mean of n chi-square variables of 12 numbers over 12; the band of all sensors together, 1 %.
  const double z = 3.6, sigma = std::sqrt(2.0 / (12.0 * n));
  fmt::print("{} arrays of {} magnetometers, {:g} Hz; verdict yes: {}\n", sums.n, s.magnetometers,
             s.rate_hz, sums.yes);
  fmt::print("density over truth    mean {:+.2f} %, worst {:.2f} % (asked: 3)\n",
             100.0 * sums.densities / sensors, 100.0 * sums.worst_density);
  fmt::print("gyroscope's           mean {:+.2f} %, worst {:.2f} % (asked: 3)\n",
             100.0 * sums.gyr / n, 100.0 * sums.worst_gyr);
  fmt::print(
      "NEES/12 of a sensor   model {:.2f} to {:.2f}, robust {:.2f} to {:.2f} (band {:.2f} to "
      "{:.2f})\n",
      least / n / 12.0, most / n / 12.0, least_robust / n / 12.0, most_robust / n / 12.0,
      std::max(0.0, 1.0 - z * sigma), 1.0 + z * sigma + z * z * sigma * sigma / 3.0);
  fmt::print("error of D and o_m    {:.4f} uT RMS", std::sqrt(sums.joint / sensors));
  if (s.one_by_one) {
    fmt::print("; one by one {:.4f}, {:.2f} times", std::sqrt(sums.alone / sensors),
               std::sqrt(sums.alone / sums.joint));
  }
  fmt::print("\nprocessor             {:.2f} s an array", sums.seconds / n);
  if (s.one_by_one) {
    fmt::print("; one by one {:.2f} s, {:.1f} times", sums.seconds_alone / n,
               sums.seconds_alone / sums.seconds);
  }
  fmt::print("\nfile                  {:.0f} kB, with the joint covariance {:.0f} kB\n",
             sums.bytes / 1e3, sums.bytes_joint / 1e3);
  fmt::print("memory                {:.0f} MB at the most\n", peak_MB());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Calibration of arrays of magnetometers, simulated"};
  Setting setting;
  app.add_option("--arrays", setting.arrays, "how many")->check(CLI::Range(1, 1000));
  app.add_option("--magnetometers", setting.magnetometers, "of one")->check(CLI::Range(2, 200));
  app.add_option("--rate", setting.rate_hz, "Hz");
  app.add_option("--duration", setting.duration_s, "s (0: 322)");
  app.add_flag("--one-by-one", setting.one_by_one, "each magnetometer by itself, too");
  CLI11_PARSE(app, argc, argv);
  Sums sums;
  for (int i = 1; i <= setting.arrays; ++i) add_array(setting, std::uint64_t(i), sums);
  print(setting, sums);
}
