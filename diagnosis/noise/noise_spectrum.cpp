// SPDX-License-Identifier: BSD-3-Clause
// Spectra of residuals and fits to them: noise_spectrum.h.
#include "diagnosis/noise/noise_spectrum.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "diagnosis/noise/high_pass.h"
#include "statistics/golden_section.h"
#include "statistics/power_spectrum.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kPieceSeconds = 2.5;
constexpr double kRoundedUp = 1.5;   // a length that is a power of two may be so much too short
constexpr int kShortestPiece = 32;   // samples
constexpr double kLowestHz = 2.5;    // hardly anything slow reaches beyond
constexpr double kLeastGain = 0.1;   // of the high-pass: below, the filter's skirts count
constexpr double kLeastUsed = 0.75;  // of a piece's samples
// Independent ordinates in the mean of m half-overlapping pieces, an axis: m / 2 pieces' worth of
// samples, less what Hann's taper loses, 2 / (35/18 + 2 * 1/12).
constexpr double kLooks = 0.5 * 2.0 / (35.0 / 18.0 + 1.0 / 6.0);

double lowest_hz(double rate_hz) { return std::min(kLowestHz, 0.1 * rate_hz); }

// Squared gain, on white noise, of replacing that fraction of the samples by what the quadratic
// through their neighbours says.
double replaced_gain(double omega, double fraction) {
  const double own = 1.0 - smoothing_weight(0);
  double variance = 0.0, coupling = 0.0;
  for (int l = 1; l <= kHighPassReach; ++l) {
    const double weight = smoothing_weight(l) / own;
    variance += 2.0 * weight * weight;
    coupling += 4.0 * weight * std::cos(l * omega);
  }
  return 1.0 - fraction * (1.0 - variance) + fraction * coupling;
}

struct Terms {
  std::vector<double> noise, slow;  // G times the two shapes
};

double ar_shape(double omega, double rho) {
  return (1.0 - rho * rho) / (1.0 + rho * rho - 2.0 * rho * std::cos(omega));
}

Terms terms(const PieceSpectra& s, double rho) {
  Terms t;
  for (std::size_t j = 0; j < s.omega.size(); ++j) {
    t.noise.push_back(s.gain[j] * ar_shape(s.omega[j], rho));
    const double r = s.omega.front() / s.omega[j];
    t.slow.push_back(s.gain[j] * r * r * r * r);
  }
  return t;
}

double whittle(const MeanSpectrum& mean, const Terms& t, double v, double b) {
  double sum = 0.0;
  for (std::size_t j = 0; j < mean.power.size(); ++j) {
    const double S = v * t.noise[j] + b * t.slow[j];
    sum -= mean.power[j] / S + std::log(S);
  }
  return mean.looks * sum;
}

// Of log v, from the information of log S on log v and b; b at its bound is held there.
double log_v_sigma(const PieceSpectra& s, const MeanSpectrum& mean, const ColourFit& fit) {
  const Terms t = terms(s, fit.rho);
  double vv = 0.0, vb = 0.0, bb = 0.0;
  for (std::size_t j = 0; j < s.omega.size(); ++j) {
    const double S = fit.v * t.noise[j] + fit.b * t.slow[j];
    const double noise = fit.v * t.noise[j] / S, slow = t.slow[j] / S;
    vv += mean.looks * noise * noise;
    vb += mean.looks * noise * slow;
    bb += mean.looks * slow * slow;
  }
  return 1.0 / std::sqrt(fit.b > 0.0 ? vv - vb * vb / bb : vv);
}

std::vector<double> hann_taper(int length) {
  std::vector<double> w(static_cast<std::size_t>(length));
  for (int k = 0; k < length; ++k) {
    w[static_cast<std::size_t>(k)] =
        0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (k + 0.5) / length);
  }
  return w;
}

int piece_length(double rate_hz, std::size_t samples) {
  int length = kShortestPiece;
  while (kRoundedUp * length < kPieceSeconds * rate_hz && std::size_t(length) < samples)
    length *= 2;
  while (length > kShortestPiece && std::size_t(length) * 6 > samples) length /= 2;
  return length;
}

// Mean over the axes, the taper's power taken out; not where too few samples are in use.
void add_piece(const NoiseSeries& s, const std::vector<Vector3>& residual, std::size_t first,
               const std::vector<double>& w, int lowest, PieceSpectra& spectra) {
  const std::size_t length = w.size();
  double weight = 0.0, full = 0.0;
  for (std::size_t k = 0; k < length; ++k) {
    full += w[k] * w[k];
    weight += s.used[first + k] ? w[k] * w[k] : 0.0;
  }
  if (weight < kLeastUsed * full) return;
  static thread_local PowerSpectrum power_of;
  std::vector<double> power(length / 2 - static_cast<std::size_t>(lowest), 0.0);
  std::vector<double> x(length);
  Vector3 least = Vector3::Constant(1e300), most = -least;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < length; ++k) {
      x[k] = w[k] * residual[first + k][axis] / spectra.unit[axis];
      if (!s.used[first + k]) continue;
      const double model = s.reading[first + k][axis] - s.residual[first + k][axis];
      least[axis] = std::min(least[axis], model);
      most[axis] = std::max(most[axis], model);
    }
    const std::vector<double> own = power_of(x);
    for (std::size_t j = 0; j < power.size(); ++j) {
      power[j] += own[j + static_cast<std::size_t>(lowest)] / (3.0 * weight);
    }
  }
  spectra.power.push_back(std::move(power));
  spectra.activity.push_back((most - least).norm());
}

// A step, or a magnet passed by, has power in a piece or two that no noise has.
void drop_loud_pieces(PieceSpectra& s) {
  constexpr double kLoud = 3.0;
  std::vector<double> low;
  for (const std::vector<double>& power : s.power) {
    const auto third = power.begin() + std::ptrdiff_t(std::max<std::size_t>(1, power.size() / 3));
    low.push_back(std::accumulate(power.begin(), third, 0.0));
  }
  if (low.size() < 8) return;
  const double usual = quantile(low, 0.5);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < low.size(); ++i) {
    if (low[i] > kLoud * usual) continue;
    if (kept != i) s.power[kept] = std::move(s.power[i]);
    s.activity[kept++] = s.activity[i];
  }
  s.power.resize(kept);
  s.activity.resize(kept);
}

}  // namespace

PieceSpectra piece_spectra(const NoiseSeries& s, const Cleaned& cleaned) {
  PieceSpectra spectra;
  spectra.length = piece_length(s.rate_hz, s.size());
  const std::vector<double> w = hann_taper(spectra.length);
  const std::size_t length = w.size();
  spectra.unit = cleaned.scale / std::sqrt(kHighPassVariance);
  const double bin = 2.0 * std::numbers::pi / spectra.length;
  int lowest = std::max(2, int(std::ceil(lowest_hz(s.rate_hz) / s.rate_hz * spectra.length)));
  while (s.high_passed && lowest < spectra.length / 2 &&
         high_pass_gain(lowest * bin) < kLeastGain) {
    ++lowest;
  }
  for (int j = lowest; j < spectra.length / 2; ++j) {
    spectra.omega.push_back(j * bin);
    spectra.gain.push_back((s.high_passed ? high_pass_gain(j * bin) : 1.0) *
                           replaced_gain(j * bin, cleaned.jump_fraction) *
                           s.of_white.power(j * s.rate_hz / spectra.length));
  }
  for (std::size_t first = 0; first + length <= s.size(); first += length / 2) {
    add_piece(s, cleaned.residual, first, w, lowest, spectra);
  }
  drop_loud_pieces(spectra);
  return spectra;
}

MeanSpectrum mean_spectrum(const PieceSpectra& s, const std::vector<char>& chosen) {
  MeanSpectrum mean;
  mean.power.assign(s.omega.size(), 0.0);
  int count = 0;
  for (std::size_t i = 0; i < s.power.size(); ++i) {
    if (!chosen.empty() && !chosen[i]) continue;
    ++count;
    for (std::size_t j = 0; j < mean.power.size(); ++j) mean.power[j] += s.power[i][j];
  }
  for (double& p : mean.power) p /= std::max(1, count);
  mean.looks = 3.0 * kLooks * count;
  return mean;
}

// Fisher scoring for v > 0 and b >= 0, rho held.
ColourFit fit_levels(const PieceSpectra& s, const MeanSpectrum& mean, double rho) {
  const Terms t = terms(s, rho);
  const std::size_t n = mean.power.size();
  ColourFit fit;
  fit.rho = rho;
  double v_alone = 0.0;
  for (std::size_t j = 0; j < n; ++j) v_alone += mean.power[j] / t.noise[j] / double(n);
  fit.v = v_alone;
  fit.log_likelihood = whittle(mean, t, v_alone, 0.0);
  // The upper half of the band is hardly touched by what is slow.
  double v = 0.0, b = 0.0;
  const std::size_t half = n / 2;
  for (std::size_t j = half; j < n; ++j) v += mean.power[j] / t.noise[j] / double(n - half);
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Eigen::Vector2d y = Eigen::Vector2d::Zero();
    for (std::size_t j = 0; j < n; ++j) {
      const double S = v * t.noise[j] + b * t.slow[j];
      const Eigen::Vector2d x(t.noise[j] / S, t.slow[j] / S);
      A += x * x.transpose();
      y += x * (mean.power[j] / S);
    }
    const Eigen::Vector2d next = A.ldlt().solve(y);
    const double v_next = std::max(next[0], 0.1 * v), b_next = std::max(0.0, next[1]);
    const bool settled = std::abs(v_next - v) < 1e-6 * v && std::abs(b_next - b) < 1e-6 * v;
    v = v_next;
    b = b_next;
    if (settled) break;
  }
  const double both = whittle(mean, t, v, b);
  if (b > 0.0 && both > fit.log_likelihood) {
    fit.v = v;
    fit.b = b;
    fit.log_likelihood = both;
  }
  return fit;
}

ColourFit fit_white(const PieceSpectra& spectra, const MeanSpectrum& mean) {
  ColourFit fit = fit_levels(spectra, mean, 0.0);
  fit.log_v_sigma = log_v_sigma(spectra, mean, fit);
  return fit;
}

// rho = tanh z: the best near that of a grid.
ColourFit fit_correlated(const PieceSpectra& spectra, const MeanSpectrum& mean) {
  const auto at = [&](double z) { return fit_levels(spectra, mean, std::tanh(z)); };
  constexpr double kStep = 0.5, kLowest = -1.5, kMost = 3.8;  // -0.905 < rho < 0.999
  constexpr double kBeyond = 0.2, kFarthest = 4.0 * kMost;    // of the search for a sigma
  constexpr double kSettled = 1e-2;                           // of the sigma
  double best = 0.0, best_value = at(0.0).log_likelihood;
  for (double z = kLowest; z <= kMost; z += kStep) {
    const double value = at(z).log_likelihood;
    if (value > best_value) {
      best = z;
      best_value = value;
    }
  }
  const double z = golden_section_minimum(best - kStep, best + kStep, 1e-3,
                                          [&](double x) { return -at(x).log_likelihood; });
  ColourFit fit = at(z);
  // Two standard deviations: where the likelihood, of the best v and b, has fallen by 2. Towards
  // rho = 1 v and rho are hardly told apart, and v goes far where rho does not.
  double v_sigma = 0.0;
  for (const double side : {-1.0, 1.0}) {
    double near = 0.0, far = 0.02;
    const auto likely = [&](double distance) {
      return std::abs(z + side * distance) < kMost + kBeyond &&
             at(z + side * distance).log_likelihood > fit.log_likelihood - 2.0;
    };
    while (far < kFarthest && likely(far)) far *= 2.0;
    while (far > 1e-6 && far - near > kSettled * far) {
      const double middle = 0.5 * (near + far);
      (likely(middle) ? near : far) = middle;
    }
    const ColourFit there = at(z + side * near);
    fit.rho_sigma = std::max(fit.rho_sigma, 0.5 * std::abs(fit.rho - there.rho));
    v_sigma = std::max(v_sigma, 0.5 * std::abs(std::log(fit.v / there.v)));
  }
  fit.log_v_sigma = std::hypot(log_v_sigma(spectra, mean, fit), v_sigma);
  return fit;
}

double log_likelihood(const PieceSpectra& spectra, const MeanSpectrum& mean,
                      const ColourFit& model) {
  return whittle(mean, terms(spectra, model.rho), model.v, model.b);
}

}  // namespace magimu
