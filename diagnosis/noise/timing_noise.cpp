// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/timing_noise.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/noise_causes.h"
#include "graph/decompositions.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kTimingBlock = 2.0;     // s: longer than noise is remembered
constexpr double kFurthest = 4.0;        // standard deviations: what is farther off counts as there
constexpr double kLongestPattern = 0.5;  // s
constexpr double kSamePattern = 0.6;     // of j^2: what returns after a period

// High-passed residuals and the two changes, in units of the residuals' size on each axis and of
// `rate`, the changes' root mean square.
struct Scaled {
  std::vector<Vector3> e, d, c;
  double rate = 0.0;  // 1/s
};

Scaled scale(const SampleResiduals& samples, const std::vector<Vector3>& residual) {
  Vector3 variance = Vector3::Zero();
  for (const Vector3& e : residual) variance += e.cwiseAbs2() / double(residual.size());
  Scaled out;
  if (!(variance.minCoeff() > 0.0)) return out;
  const Vector3 size = variance.cwiseSqrt();
  // The high pass takes as much of the jitter as of white noise.
  const Vector3 passed = size / std::sqrt(kHighPassVariance);
  for (std::size_t k = 0; k < residual.size(); ++k) {
    const Vector3 e = residual[k].cwiseQuotient(size);
    out.e.push_back(e * std::min(1.0, kFurthest / std::max(e.norm(), 1e-300)));
    out.d.push_back(samples.change[k].cwiseQuotient(passed));
    out.c.push_back(samples.across[k].cwiseQuotient(passed));
    out.rate += out.d.back().squaredNorm() / double(residual.size());
  }
  out.rate = std::sqrt(out.rate);
  for (Vector3& d : out.d) d /= std::max(out.rate, 1e-300);
  for (Vector3& c : out.c) c /= std::max(out.rate, 1e-300);
  return out;
}

// The six numbers of a symmetric matrix, scaled so that their norm is the matrix's (Frobenius).
constexpr int kNumbers = 6, kUnknowns = 10, kJitter = kUnknowns - 1;
using Square = Eigen::Matrix<double, kNumbers, 1>;
using Regressors = Eigen::Matrix<double, kNumbers, kUnknowns>;

Square square_of(const Matrix3& m) {
  Square out;
  out << m.diagonal(), std::sqrt(2.0) * Vector3(m(0, 1), m(1, 2), m(2, 0));
  return out;
}

// What S, a, b, g and j^2 are multiplied by in E[e e'].
Regressors regressors(const Vector3& d, const Vector3& c) {
  const Matrix3 plane = d * d.transpose() + c * c.transpose();
  Regressors X;
  X.leftCols<kNumbers>().setIdentity();
  X.col(6) = square_of(plane / std::max(d.squaredNorm(), 1e-300));
  X.col(7) = square_of(plane);
  X.col(8) = square_of(d.squaredNorm() * Matrix3::Identity());
  X.col(kJitter) = square_of(d * d.transpose());
  return X;
}

// Of some samples, the normal equations of E[e e'].
struct Equations {
  Eigen::Matrix<double, kUnknowns, kUnknowns> N = decltype(N)::Zero();
  Eigen::Matrix<double, kUnknowns, 1> sum = decltype(sum)::Zero();
};

// Block by block of kTimingBlock.
std::vector<Equations> equations(const std::vector<double>& t, const Scaled& s) {
  std::vector<Equations> out(1);
  double begin = t.front();
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (t[k] - begin > kTimingBlock) {
      begin = t[k];
      out.emplace_back();
    }
    const Regressors X = regressors(s.d[k], s.c[k]);
    out.back().N += X.transpose() * X;
    out.back().sum += X.transpose() * square_of(s.e[k] * s.e[k].transpose());
  }
  return out;
}

// E[tau_k tau_k+lag], from what lies along the changes at both less what lies across.
double covariance_at(const Scaled& s, std::size_t lag) {
  double score = 0.0, information = 0.0;
  for (std::size_t k = 0; k + lag < s.e.size(); ++k) {
    const std::size_t l = k + lag;
    score += s.d[k].dot(s.e[k]) * s.d[l].dot(s.e[l]) - s.c[k].dot(s.e[k]) * s.c[l].dot(s.e[l]);
    information +=
        s.d[k].squaredNorm() * s.d[l].squaredNorm() - s.c[k].dot(s.d[k]) * s.c[l].dot(s.d[l]);
  }
  return score / std::max(information, 1e-300);
}

// The first lag beyond the high pass' own after which as much as at none is back.
double period_of(const Scaled& s, double variance, double rate_hz) {
  const auto most = std::min(std::size_t(kLongestPattern * rate_hz), s.e.size() / 10);
  double before = 0.0, at = 0.0;
  for (std::size_t lag = 2 * kHighPassReach; lag <= most + 1; ++lag) {
    const double after = covariance_at(s, lag);
    if (at > kSamePattern * variance && at >= before && at >= after)
      return double(lag - 1) / rate_hz;
    before = at;
    at = after;
  }
  return 0.0;
}

}  // namespace

TimingNoise timing_noise(const SampleResiduals& samples) {
  TimingNoise out;
  const std::size_t n = samples.t.size();
  if (n < kLeastSamples || samples.change.size() != n) return out;
  VectorSeries series;
  for (std::size_t k = 0; k < n; ++k) series.push_back(samples.t[k], samples.residual[k]);
  const Scaled s = scale(samples, high_passed(series));
  if (s.e.empty()) return out;
  const std::vector<Equations> blocks = equations(samples.t, s);
  if (blocks.size() < 2 * kUnknowns) return out;
  Equations all;
  for (const Equations& own : blocks) {
    all.N += own.N;
    all.sum += own.sum;
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr{MatrixXd(all.N)};
  if (qr.rank() < kUnknowns) return out;
  const VectorXd theta = qr.solve(VectorXd(all.sum)),
                 weights = qr.solve(VectorXd(VectorXd::Unit(kUnknowns, kJitter)));
  const double variance = theta[kJitter];
  if (!(variance > 0.0)) return out;
  out.jitter_s = std::sqrt(variance) / s.rate;
  out.added = variance / 3.0;
  // The estimate's error is a sum over blocks, and scatters as they do.
  double squares = 0.0;
  for (const Equations& own : blocks) {
    squares += std::pow(weights.dot(own.sum - own.N * theta), 2);
  }
  const auto dof = double(blocks.size() - kUnknowns);
  const double sigma = std::sqrt(squares * double(blocks.size()) / dof);
  out.log10_p = log10_student_tail(variance / sigma, dof);
  constexpr double kWorthLooking = -4.0;
  if (out.log10_p < kWorthLooking) out.period_s = period_of(s, variance, series.rate_hz());
  return out;
}

}  // namespace magimu
