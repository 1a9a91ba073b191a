// SPDX-License-Identifier: BSD-3-Clause
// A local quadratic taken from samples: high_pass.h.
#include "diagnosis/noise/high_pass.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kUneven =
    0.1;  // of an interval: there the quadratic is fitted at the samples' own times
constexpr int kFilterLength = 2 * kHighPassReach + 1;
constexpr std::array<double, kHighPassReach + 1> kWeights = {
    59.0 / 231.0, 54.0 / 231.0, 39.0 / 231.0, 14.0 / 231.0, -21.0 / 231.0};

// The sample `at` less the quadratic in time through the kFilterLength samples from `first` on.
Vector3 less_quadratic(const VectorSeries& s, std::size_t first, std::size_t at, double dt) {
  MatrixXd basis(kFilterLength, 3), values(kFilterLength, 3);
  for (int i = 0; i < kFilterLength; ++i) {
    const std::size_t k = first + static_cast<std::size_t>(i);
    const double u = (s.t[k] - s.t[at]) / dt;
    basis.row(i) << 1.0, u, u * u;
    values.row(i) = s.v[k].transpose();
  }
  const MatrixXd fit = Eigen::ColPivHouseholderQR<MatrixXd>(basis).solve(values);
  return s.v[at] - fit.row(0).transpose();
}

}  // namespace

double smoothing_weight(int lag) {
  const int l = std::abs(lag);
  return l > kHighPassReach ? 0.0 : kWeights[static_cast<std::size_t>(l)];
}

double high_pass_gain(double omega) {
  double passed = 1.0 - smoothing_weight(0);
  for (int l = 1; l <= kHighPassReach; ++l) {
    passed -= 2.0 * smoothing_weight(l) * std::cos(l * omega);
  }
  return passed * passed;
}

std::vector<Vector3> high_passed(const VectorSeries& series) {
  const std::size_t n = series.size(), reach = kHighPassReach;
  std::vector<Vector3> result(n, Vector3::Zero());
  if (n < kFilterLength) return result;
  const double dt = 1.0 / series.rate_hz();
  const auto even = [&](std::size_t first) {
    for (std::size_t k = first + 1; k < first + kFilterLength; ++k) {
      if (std::abs(series.t[k] - series.t[k - 1] - dt) > kUneven * dt) return false;
    }
    return true;
  };
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t first = std::min(k < reach ? 0 : k - reach, n - kFilterLength);
    if (first + reach != k || !even(first)) {
      result[k] = less_quadratic(series, first, k, dt);
      continue;
    }
    result[k] = series.v[k];
    for (int l = -kHighPassReach; l <= kHighPassReach; ++l) {
      result[k] -= smoothing_weight(l) * series.v[k + static_cast<std::size_t>(l)];
    }
  }
  return result;
}

std::vector<Vector3> high_passed(const std::vector<Vector3>& values) {
  VectorSeries series;
  for (std::size_t k = 0; k < values.size(); ++k) series.push_back(double(k), values[k]);
  return high_passed(series);
}

}  // namespace magimu
