// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rest_noise/allan.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

// Equivalent degrees of freedom of the overlapping estimate with white noise: NIST Special
// Publication 1065, table 5 (white FM). n: phase points, m: samples a cluster.
double degrees_of_freedom(double n, double m) {
  const double edf =
      (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * 4.0 * m * m / (4.0 * m * m + 5.0);
  return std::max(1.0, edf);
}

// Quantile of chi-square over its degrees of freedom (Wilson and Hilferty).
double chi_square_ratio(double freedom, double normal_quantile) {
  const double k = 2.0 / (9.0 * freedom);
  return std::pow(std::max(0.05, 1.0 - k + normal_quantile * std::sqrt(k)), 3);
}

}  // namespace

std::vector<AllanPoint> allan_deviation(const std::vector<double>& values, double interval_s,
                                        int per_decade) {
  const std::size_t n = values.size();
  // The sum of the values, less their mean so that no digits are lost.
  double mean = 0.0;
  for (const double v : values) mean += v / double(std::max<std::size_t>(1, n));
  std::vector<double> sum{0.0};
  for (const double v : values) sum.push_back(sum.back() + (v - mean));
  std::vector<AllanPoint> out;
  std::size_t last = 0;
  for (int step = 0;; ++step) {
    const auto m = std::size_t(std::llround(std::pow(10.0, double(step) / per_decade)));
    if (3 * m > n) break;
    if (m == last) continue;
    last = m;
    double squares = 0.0;
    const std::size_t terms = n + 1 - 2 * m;
    for (std::size_t k = 0; k < terms; ++k) {
      const double d = sum[k + 2 * m] - 2.0 * sum[k + m] + sum[k];
      squares += d * d;
    }
    const double variance = squares / (2.0 * double(terms) * double(m) * double(m));
    const double freedom = degrees_of_freedom(double(n + 1), double(m));
    out.push_back({double(m) * interval_s, std::sqrt(variance),
                   std::sqrt(variance / chi_square_ratio(freedom, 1.96)),
                   std::sqrt(variance / chi_square_ratio(freedom, -1.96))});
  }
  return out;
}

double model_deviation(const AxisNoise& noise, double tau_s) {
  const double N = noise.white.value, B = noise.bias_instability.value, K = noise.random_walk.value;
  return std::sqrt(N * N / tau_s + 2.0 * std::log(2.0) / M_PI * B * B + K * K * tau_s / 3.0);
}

}  // namespace magimu
