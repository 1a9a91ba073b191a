// SPDX-License-Identifier: BSD-3-Clause
// N, B and K of an axis by maximum likelihood. The differences of block means d_k = y_k+1 - y_k
// (blocks of T seconds) have the spectrum, at omega from 0 to pi,
//
//   S = N^2 / T (2 - 2 cos omega) + B^2 a(omega) (2 - 2 cos omega) + K^2 T (2 + cos omega) / 3
//
// the last being that of a walk's means; a(omega) is the flicker spectrum 1 / (2 pi f) of the block
// means with what folds down from above. White noise and walk have tridiagonal covariances, which
// the discrete sine transform makes diagonal: for them the likelihood is exact, at every length.
// S is linear in (N^2, B^2, K^2), which are not negative: scoring (least squares with weights
// 1 / S^2) over the faces of that octant.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <unsupported/Eigen/FFT>

#include "calibration/rest_noise/allan.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMinBlocks = 100;
constexpr int kMaxFitSteps = 60;
constexpr double kSettledFit = 1e-8;
constexpr double kConfidence = 1.96;       // standard deviations of 95 %
constexpr double kWorthAParameter = 6.63;  // chi-square with one degree of freedom, 1 %
constexpr int kFolds = 8;                  // of the flicker spectrum, on each side
constexpr int kWhite = 0, kFlicker = 1, kWalk = 2;

double variance(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v - values.front();
  const double mean = values.front() + sum / double(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  return squares / double(values.size() - 1);
}

std::vector<double> block_means(const std::vector<double>& values, std::size_t m) {
  std::vector<double> out(values.size() / m, 0.0);
  for (std::size_t k = 0; k < out.size() * m; ++k) out[k / m] += values[k] / double(m);
  return out;
}

// Squared sine transform of the differences, and the three spectra there.
struct Spectrum {
  VectorXd power;
  MatrixXd shape;  // one column a parameter
};

// The largest number up to n that has no prime factor above 5: the transform's lengths.
std::size_t fast_length(std::size_t n) {
  for (;; --n) {
    std::size_t rest = n;
    for (const std::size_t factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return n;
  }
}

// sqrt(2 / (n + 1)) sum_j x_j sin(pi j k / (n + 1)), an orthogonal transform.
VectorXd sine_transform(const std::vector<double>& x) {
  const std::size_t n = x.size();
  std::vector<double> odd(2 * (n + 1), 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    odd[j + 1] = x[j];
    odd[odd.size() - 1 - j] = -x[j];
  }
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  fft.fwd(transform, odd);
  VectorXd out{Index(n)};
  const double scale = -0.5 * std::sqrt(2.0 / double(n + 1));
  for (std::size_t k = 0; k < n; ++k) out[Index(k)] = scale * transform[k + 1].imag();
  return out;
}

Spectrum spectrum_of(const std::vector<double>& means, double block_s) {
  std::vector<double> difference;
  for (std::size_t k = 1; k < means.size(); ++k) difference.push_back(means[k] - means[k - 1]);
  difference.resize(fast_length(means.size()) - 1);
  const auto n = Index(difference.size());
  Spectrum s{sine_transform(difference).cwiseAbs2(), MatrixXd(n, 3)};
  for (Index k = 0; k < n; ++k) {
    const double omega = M_PI * double(k + 1) / double(n + 1);
    const double twice = 2.0 - 2.0 * std::cos(omega);
    double flicker = 0.0;
    for (int fold = -kFolds; fold <= kFolds; ++fold) {
      // Per block: B^2 / (2 pi f) with f in 1 / s, over the block's length, times sinc^2.
      const double w = std::abs(omega + 2.0 * M_PI * fold);
      const double sinc = std::sin(0.5 * w) / (0.5 * w);
      flicker += sinc * sinc / w;
    }
    s.shape.row(k) << twice / block_s, twice * flicker, block_s * (2.0 + std::cos(omega)) / 3.0;
  }
  return s;
}

MatrixXd inverse_of(const MatrixXd& A) {
  return A.ldlt().solve(MatrixXd(MatrixXd::Identity(A.rows(), A.cols())));
}

struct Fit {
  Vector3d theta = Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double deviance = INFINITY;  // twice the negative log-likelihood
};

// With the parameters of a face only; nothing if one of them is not positive at its best.
std::optional<Fit> fit_on(const Spectrum& s, const std::vector<int>& free) {
  const auto n = Index(free.size());
  MatrixXd A(s.power.size(), n);
  for (Index i = 0; i < n; ++i) A.col(i) = s.shape.col(free[std::size_t(i)]);
  VectorXd theta(n);
  for (Index i = 0; i < n; ++i) theta[i] = s.power.mean() / A.col(i).mean() / double(n);
  MatrixXd information;
  for (int step = 0; step < kMaxFitSteps; ++step) {
    const VectorXd S = A * theta;
    const MatrixXd weighted = S.cwiseInverse().asDiagonal() * A;
    information = weighted.transpose() * weighted;
    const VectorXd right = weighted.transpose() * s.power.cwiseQuotient(S);
    VectorXd next = information.ldlt().solve(right);
    if (!next.allFinite()) return std::nullopt;
    // A step that would leave the face goes half of the way to its edge.
    for (Index i = 0; i < n; ++i) next[i] = std::max(next[i], 0.1 * theta[i]);
    const double change = ((next - theta).cwiseAbs().cwiseQuotient(theta)).maxCoeff();
    theta = next;
    if (change < kSettledFit) break;
  }
  const VectorXd S = A * theta;
  Fit fit;
  // Squares of one normal number each.
  const MatrixXd covariance = 2.0 * inverse_of(information);
  for (Index i = 0; i < n; ++i) {
    if (theta[i] < 1e-3 * std::sqrt(covariance(i, i))) return std::nullopt;
    fit.theta[free[std::size_t(i)]] = theta[i];
    for (Index j = 0; j < n; ++j) {
      fit.covariance(free[std::size_t(i)], free[std::size_t(j)]) = covariance(i, j);
    }
  }
  fit.deviance = (S.array().log() + s.power.array() / S.array()).sum();
  return fit;
}

// White noise always; of flicker and walk what is worth its parameter.
Fit best_fit(const Spectrum& s) {
  Fit best = fit_on(s, {kWhite}).value_or(Fit{});
  const std::vector<std::vector<int>> more = {
      {kWhite, kWalk}, {kWhite, kFlicker}, {kWhite, kFlicker, kWalk}};
  std::size_t size = 1;
  for (const std::vector<int>& free : more) {
    const std::optional<Fit> fit = fit_on(s, free);
    if (!fit) continue;
    const double price = kWorthAParameter * double(free.size() - size);
    if (fit->deviance < best.deviance - price) {
      best = *fit;
      size = free.size();
    }
  }
  return best;
}

// How large a parameter could be that was not worth including: from the information about it with
// the others as they are fitted.
double largest_unseen(const Spectrum& s, const Fit& fit, int parameter) {
  const VectorXd S = s.shape * fit.theta;
  const MatrixXd weighted = S.cwiseInverse().asDiagonal() * s.shape;
  std::vector<int> all;
  for (int i = 0; i < 3; ++i) {
    if (fit.theta[i] > 0.0 || i == parameter) all.push_back(i);
  }
  MatrixXd A(s.power.size(), Index(all.size()));
  Index own = 0;
  for (Index i = 0; i < A.cols(); ++i) {
    A.col(i) = weighted.col(all[std::size_t(i)]);
    if (all[std::size_t(i)] == parameter) own = i;
  }
  const MatrixXd covariance = 2.0 * inverse_of(A.transpose() * A);
  const VectorXd score = A.transpose() * (s.power.cwiseQuotient(S) - VectorXd::Ones(S.size()));
  const double estimate = std::max(0.0, 0.5 * (covariance * score)[own]);
  return estimate + kConfidence * std::sqrt(covariance(own, own));
}

Bounded bounded(const Spectrum& s, const Fit& fit, int parameter) {
  const double theta = fit.theta[parameter];
  if (!(theta > 0.0)) return {0.0, 0.0, std::sqrt(largest_unseen(s, fit, parameter)), false};
  const double reach = kConfidence * std::sqrt(fit.covariance(parameter, parameter));
  return {std::sqrt(theta), std::sqrt(std::max(0.0, theta - reach)), std::sqrt(theta + reach),
          theta > reach};
}

}  // namespace

AxisNoise fit_noise(const std::vector<double>& values, double interval_s,
                    const NoiseFitOptions& options) {
  AxisNoise out;
  const auto m =
      std::size_t(std::max(1.0, std::round(options.block_s / std::max(interval_s, 1e-9))));
  if (values.size() < kMinBlocks * m || !(variance(values) > 0.0)) return out;
  const double block_s = double(m) * interval_s;
  const Spectrum s = spectrum_of(block_means(values, m), block_s);
  const Fit fit = best_fit(s);
  out.white = bounded(s, fit, kWhite);
  out.bias_instability = bounded(s, fit, kFlicker);
  out.random_walk = bounded(s, fit, kWalk);
  std::vector<double> steps;
  for (std::size_t k = 1; k < values.size(); ++k) steps.push_back(values[k] - values[k - 1]);
  out.sample_density = std::sqrt(0.5 * variance(steps) * interval_s);
  out.points = allan_deviation(values, interval_s);
  const auto lowest = std::min_element(
      out.points.begin(), out.points.end(),
      [](const AllanPoint& a, const AllanPoint& b) { return a.deviation < b.deviation; });
  out.lowest = *lowest;
  out.still_falling = out.points.end() - lowest <= 2;
  return out;
}

}  // namespace magimu
