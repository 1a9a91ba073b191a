// SPDX-License-Identifier: BSD-3-Clause
// Residuals on a grid, cleaned: noise_series.h.
#include "diagnosis/noise/noise_series.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/high_pass.h"
#include "statistics/median_to_sigma.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr int kSweeps = 12;
constexpr double kMissing = 1.5;       // usual intervals: a longer one lacks a sample
constexpr std::size_t kForScale = 10;  // values; of fewer no scale is made

// Places of the samples on an even grid; every sample the next place where the times allow none.
std::vector<std::size_t> grid_places(const std::vector<double>& t, double rate_hz) {
  std::vector<std::size_t> place(t.size());
  bool fits = true;
  for (std::size_t k = 0; k < t.size(); ++k) {
    place[k] = static_cast<std::size_t>(std::llround((t[k] - t.front()) * rate_hz));
    fits = fits && (k == 0 || place[k] > place[k - 1]);
  }
  if (fits && place.back() < 2 * t.size()) return place;
  for (std::size_t k = 0; k < t.size(); ++k) place[k] = k;
  return place;
}

// From the mean interval of the samples where none is missing. (The median has the resolution of
// the clock's ticks.)
double even_rate_hz(const std::vector<double>& t) {
  std::vector<double> dt(t.size() - 1);
  for (std::size_t k = 0; k < dt.size(); ++k) dt[k] = t[k + 1] - t[k];
  const double usual = quantile(dt, 0.5);
  double sum = 0.0;
  int count = 0;
  for (const double d : dt) {
    if (d > kMissing * usual) continue;
    sum += d;
    ++count;
  }
  return count / sum;
}

// The standard deviation sigma for which values within 2.5 sigma have the mean square that
// Gaussian ones have there, from the median on.
double scale_of_sizes(const std::vector<double>& size) {
  if (size.size() < kForScale) return 0.0;
  double sigma = kMedianToSigma * quantile(size, 0.5);
  constexpr double kWithin = 2.5, kMeanSquare = 0.911257;  // of N(0, 1) within 2.5
  for (int i = 0; i < 6; ++i) {
    double sum = 0.0;
    int count = 0;
    for (const double x : size) {
      if (x > kWithin * sigma) continue;
      sum += x * x;
      ++count;
    }
    if (count == 0) break;
    sigma = std::sqrt(sum / count / kMeanSquare);
  }
  return sigma;
}

// At their own times, so that a gap makes no step.
std::vector<Vector3> high_passed_where_used(const NoiseSeries& s) {
  VectorSeries used;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) used.push_back(s.t[k], s.residual[k]);
  }
  const std::vector<Vector3> passed = high_passed(used);
  std::vector<Vector3> result(s.size(), Vector3::Zero());
  for (std::size_t k = 0, i = 0; k < s.size(); ++k) {
    if (s.used[k]) result[k] = passed[i++];
  }
  return result;
}

}  // namespace

std::size_t NoiseSeries::used_count() const {
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), char(1)));
}

void NoiseSeries::drop(std::size_t k) {
  used[k] = 0;
  residual[k].setZero();
}

NoiseSeries make_noise_series(const SampleResiduals& r) {
  NoiseSeries s;
  s.channel = r.channel;
  s.sigma = r.sigma;
  s.sigma_given = r.sigma_given;
  s.high_passed = r.high_passed;
  s.of_white = r.of_white;
  s.lag1_at_rest = r.lag1_at_rest;
  s.readings_at_rest = r.readings_at_rest;
  if (r.t.size() < 2) return s;
  s.rate_hz = even_rate_hz(r.t);
  const std::vector<std::size_t> place = grid_places(r.t, s.rate_hz);
  const std::size_t n = place.back() + 1;
  s.t.resize(n);
  for (std::size_t k = 0; k < n; ++k) s.t[k] = r.t.front() + double(k) / s.rate_hz;
  s.reading.assign(n, Vector3::Zero());
  s.residual.assign(n, Vector3::Zero());
  s.used.assign(n, 0);
  if (!r.to_n.empty()) s.to_n.assign(n, Matrix3::Identity());
  if (!r.change.empty()) s.change.assign(n, Vector3::Zero());
  for (std::size_t i = 0; i < place.size(); ++i) {
    const std::size_t k = place[i];
    s.t[k] = r.t[i];
    if (!r.residual[i].allFinite()) continue;
    s.reading[k] = r.reading[i];
    s.residual[k] = r.residual[i];
    s.used[k] = 1;
    if (!r.to_n.empty()) s.to_n[k] = r.to_n[i];
    if (!r.change.empty() && r.change[i].allFinite()) s.change[k] = r.change[i];
  }
  return s;
}

Vector3 robust_scale(const std::vector<Vector3>& values, const std::vector<char>& used) {
  Vector3 scale;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> size;
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (used[k]) size.push_back(std::abs(values[k][axis]));
    }
    scale[axis] = scale_of_sizes(std::move(size));
  }
  return scale;
}

// The algorithm CLEAN of radio astronomy: the largest value of each neighbourhood is a jump. The
// filter's response to that jump is subtracted, and the search goes on in what is left.
Cleaned clean(const NoiseSeries& s) {
  const std::size_t n = s.size();
  constexpr std::size_t kReach = kHighPassReach;
  Cleaned c;
  c.own = s.high_passed ? s.residual : high_passed_where_used(s);
  c.scale = robust_scale(c.own, s.used).cwiseMax(1e-300);
  c.jump.assign(n, Vector3::Zero());
  const double filtered = 1.0 - smoothing_weight(0);  // of a jump at its own sample
  std::vector<double> size(n);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t k = 0; k < n; ++k) {
      size[k] = c.own[k].cwiseQuotient(c.scale).squaredNorm();
    }
    bool found = false;
    for (std::size_t k = 0; k < n; ++k) {
      if (size[k] < kSticksOut) continue;
      const std::size_t first = k < kReach ? 0 : k - kReach, last = std::min(n - 1, k + kReach);
      if (*std::max_element(size.begin() + std::ptrdiff_t(first),
                            size.begin() + std::ptrdiff_t(last) + 1) > size[k]) {
        continue;
      }
      found = true;
      const Vector3 jump = c.own[k] / filtered;
      c.jump[k] += jump;
      for (std::size_t j = first; j <= last; ++j) {
        const int lag = static_cast<int>(j) - static_cast<int>(k);
        c.own[j] -= ((lag == 0 ? 1.0 : 0.0) - smoothing_weight(lag)) * jump;
      }
      // Samples within its reach wait for the next sweep: their sizes were taken before.
      k = last;
    }
    if (!found) break;
  }
  c.residual = s.residual;
  std::size_t jumps = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if (c.jump[k].isZero(0.0)) continue;
    c.own[k] += filtered * c.jump[k];
    if (c.own[k].cwiseQuotient(c.scale).squaredNorm() < kTakenOut) {
      c.jump[k].setZero();
      continue;
    }
    ++jumps;
    if (!s.high_passed) {
      c.residual[k] -= c.jump[k];
      continue;
    }
    for (std::size_t j = k < kReach ? 0 : k - kReach; j <= std::min(n - 1, k + kReach); ++j) {
      const int lag = static_cast<int>(j) - static_cast<int>(k);
      c.residual[j] -= ((lag == 0 ? 1.0 : 0.0) - smoothing_weight(lag)) * c.jump[k];
    }
  }
  c.jump_fraction = double(jumps) / std::max<double>(1.0, double(s.used_count()));
  return c;
}

}  // namespace magimu
