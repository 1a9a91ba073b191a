// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/fit_spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <unsupported/Eigen/FFT>

#include "calibration/model/extension.h"
#include "calibration/model/sensed_motion.h"
#include "solvers/back_ends.h"
#include "solvers/linear/linear_solver.h"

namespace magimu {
namespace {

constexpr int kProbes = 4;
constexpr std::size_t kPiece = 64;  // nodes
constexpr double kLeastCorner = 0.005, kMostCorner = 2.0;
constexpr int kCorners = 200;  // tried, evenly in the logarithm

// Of random numbers z in the sensor's rows, and of what the fit takes of them, H z: the rows of
// each of the recording's nodes and components, one after another. Empty where some have none.
using Series = std::vector<double>;
std::array<Series, 3> by_component(const VectorXd& x, const std::vector<std::array<int, 3>>& row) {
  std::array<Series, 3> out;
  for (const std::array<int, 3>& rows : row) {
    for (std::size_t c = 0; c < 3; ++c) out[c].push_back(x[rows[c]]);
  }
  return out;
}

std::vector<std::array<int, 3>> rows_of_nodes(const SensorRows& rows, Sensor sensor,
                                              const NodePlan& plan) {
  std::vector<std::array<int, 3>> out(plan.t.size());
  std::vector<std::size_t> seen(plan.t.size(), 0);
  for (std::size_t i = 0; i < rows.sensor.size(); ++i) {
    const int node = rows.node[i] - plan.first;
    if (rows.sensor[i] != sensor || node < 0 || node >= int(plan.t.size())) continue;
    const auto n = std::size_t(node);
    if (seen[n] < 3) out[n][seen[n]++] = int(i);
  }
  std::vector<std::array<int, 3>> with_rows;
  for (std::size_t n = 0; n < out.size(); ++n) {
    if (seen[n] == 3) with_rows.push_back(out[n]);
  }
  return with_rows;
}

// Sums over pieces of Re(conj(Z) A) and |Z|^2 at each frequency.
struct CrossSpectrum {
  std::vector<double> both = std::vector<double>(kPiece / 2), own = both;

  void add(const Series& z, const Series& a) {
    Eigen::FFT<double> fft;
    std::vector<double> piece(kPiece);
    std::vector<std::complex<double>> Z, A;
    const auto transform = [&](const Series& x, std::size_t first,
                               std::vector<std::complex<double>>& X) {
      for (std::size_t k = 0; k < kPiece; ++k) {
        const double hann = 0.5 - 0.5 * std::cos(2.0 * M_PI * (double(k) + 0.5) / double(kPiece));
        piece[k] = hann * x[first + k];
      }
      fft.fwd(X, piece);
    };
    for (std::size_t first = 0; first + kPiece <= z.size(); first += kPiece / 2) {
      transform(z, first, Z);
      transform(a, first, A);
      for (std::size_t j = 0; j < both.size(); ++j) {
        both[j] += (std::conj(Z[j]) * A[j]).real();
        own[j] += std::norm(Z[j]);
      }
    }
  }
};

// The nearest of the form, from the second frequency on: the taper spreads the mean into the
// first.
FitSpectrum nearest(const CrossSpectrum& spectrum, double nodes_per_s) {
  FitSpectrum best;
  double least = INFINITY;
  for (int i = 0; i < kCorners; ++i) {
    FitSpectrum f{1.0, kLeastCorner * std::pow(kMostCorner / kLeastCorner, double(i) / kCorners),
                  nodes_per_s};
    double xx = 0.0, xy = 0.0, yy = 0.0;
    for (std::size_t j = 2; j < spectrum.own.size(); ++j) {
      const double x = f.followed(double(j) * nodes_per_s / double(kPiece));
      const double y = spectrum.both[j] / spectrum.own[j];
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
    f.share = std::clamp(xy / xx, 0.0, 1.0);
    const double left = yy - 2.0 * f.share * xy + f.share * f.share * xx;
    if (left < least) {
      least = left;
      best = f;
    }
  }
  return best;
}

double walk_of(const Stage& stage, Sensor sensor) {
  const NoiseDensities& noise = stage.spec().noise;
  const Matrix3& D = stage.result().values.at<Matrix3>(key::distortion);
  const double squares =
      sensor == Sensor::kMag ? D.squaredNorm() / 3.0 : stage.spec().gravity * stage.spec().gravity;
  const double own = sensor == Sensor::kMag ? noise.mag : noise.acc;
  return squares * noise.gyr * noise.gyr / (own * own);
}

// Of n x r the mean variance of the components is 2/3 |r|^2 that of n.
double arm_of(const Stage& stage, Sensor sensor) {
  if (sensor != Sensor::kAcc) return 0.0;
  const ModelSpec& spec = stage.spec();
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (spec.effects[i]->name() != "lever_arm") continue;
    const VectorXd r = effect_parameters(stage.result().values, keys[i]);
    return 2.0 / 3.0 * r.squaredNorm() * std::pow(spec.noise.gyr / spec.noise.acc, 2);
  }
  return 0.0;
}

// Square of the response, 1/s^2, of the slope of a line through readings about a sample
// (SensedMotion::rate_about).
double slope_response(double hz, double rate_hz) {
  const int each_side = 1 + std::max(0, int(std::floor(kSlopeAround * rate_hz - 0.5)));
  double sum = 0.0, squares = 0.0;
  for (int j = 0; j < each_side; ++j) {
    const double t = (j + 0.5) / rate_hz;
    sum += 2.0 * t * std::sin(2.0 * M_PI * hz * t);
    squares += 2.0 * t * t;
  }
  return std::pow(sum / squares, 2);
}

}  // namespace

double FitSpectrum::followed(double hz) const {
  const double r = std::sin(M_PI * hz / nodes_per_s) / corner;
  return share / (1.0 + r * r);
}

// A node has the mean of its samples' noise n less the walk W, and follows it by h; a sample is off
// by its own noise, the walk, and what the line from node to node follows: with the response s of
// the mean to a frequency, s^2 of the line, and s_k, W_k at the frequencies that nodes take for it,
//
//   (1 + W) (1 - 2 h s^3) + h^2 s^4 sum_k s_k^2 (1 + W_k),   W = walk / w^2.
double FitSpectrum::power(double hz) const {
  constexpr int kAliases = 3;
  constexpr double kAcross = 2.0 / 3.0;
  const auto response = [&](double f) {
    const double x = M_PI * f / nodes_per_s;
    return f == 0.0 ? 1.0 : std::sin(x) / x;
  };
  const auto walked = [&](double f) { return walk / std::max(1e-9, std::pow(2.0 * M_PI * f, 2)); };
  double aliased = 1.0;  // sum of s_k^2 is 1
  for (int k = -kAliases; k <= kAliases; ++k) {
    const double f = hz + k * nodes_per_s;
    aliased += std::pow(response(f), 2) * walked(f);
  }
  const double h = std::min(1.0, followed(hz) / kAcross), s = response(hz);
  const double across =
      (1.0 + walked(hz)) * (1.0 - 2.0 * h * std::pow(s, 3)) + h * h * std::pow(s, 4) * aliased;
  return 1.0 - kAcross + kAcross * across + (arm > 0.0 ? arm * slope_response(hz, rate_hz) : 0.0);
}

FitSpectrum fit_spectrum(const Stage& stage, Sensor sensor, int index, double gyr_hz) {
  const Values& values = stage.result().values;
  const NodePlan& plan = stage.plans()[std::size_t(index)];
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const SensorRows sensors(stage.graph(), system);
  const std::vector<std::array<int, 3>> rows = rows_of_nodes(sensors, sensor, plan);
  const VectorXd scale = column_scale(system);
  const auto solver = make_linear_solver(Backend::kAuto);
  if (rows.size() < 2 * kPiece || !solver->factorize(system, scale, 0.0)) return {};
  std::mt19937_64 random(20251124);
  MatrixXd z = MatrixXd::Zero(system.rows(), kProbes), B = MatrixXd::Zero(system.cols(), kProbes);
  for (int i = 0; i < system.rows(); ++i) {
    if (sensors.sensor[std::size_t(i)] != sensor) continue;
    const std::uint64_t bits = random();
    for (int p = 0; p < kProbes; ++p) z(i, p) = ((bits >> p) & 1U) != 0U ? 1.0 : -1.0;
    for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
         ++e) {
      const int column = system.column()[std::size_t(e)];
      B.row(column) += scale[column] * system.value()[std::size_t(e)] * z.row(i);
    }
  }
  const MatrixXd X = scale.asDiagonal() * solver->solve_normal(B);
  CrossSpectrum spectrum;
  for (int p = 0; p < kProbes; ++p) {
    const std::array<Series, 3> own = by_component(z.col(p), rows),
                                taken = by_component(system.multiply(X.col(p)), rows);
    for (std::size_t c = 0; c < 3; ++c) spectrum.add(own[c], taken[c]);
  }
  const double nodes_per_s = double(rows.size()) / std::max(1e-9, plan.t.back() - plan.t.front());
  FitSpectrum out = nearest(spectrum, nodes_per_s);
  out.walk = walk_of(stage, sensor);
  out.arm = arm_of(stage, sensor);
  out.rate_hz = gyr_hz;
  return out;
}

}  // namespace magimu
