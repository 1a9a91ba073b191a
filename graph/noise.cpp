// SPDX-License-Identifier: BSD-3-Clause
#include "graph/noise.h"

#include <vector>

namespace magimu::detail {
namespace {

constexpr double kSymmetricWithin = 1e-6;  // correlation; rounding leaves far less

}  // namespace

bool find_whitening(const double* covariance, int n, double* whitening) {
  const bool finite =
      std::all_of(covariance, covariance + n * n, [](double x) { return std::isfinite(x); });
  if (!finite) return false;
  const auto at = [n](int row, int column) { return std::size_t(row + column * n); };
  // Only the lower triangle is read below. Whoever filled in the upper one alone would get
  // independent components.
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      const double apart = std::abs(covariance[at(i, j)] - covariance[at(j, i)]);
      const double scale = std::sqrt(std::abs(covariance[at(i, i)] * covariance[at(j, j)]));
      if (apart > kSymmetricWithin * scale) return false;
    }
  }
  std::fill_n(whitening, n * n, 0.0);
  // Row by row: L_ij for j < i from the rows above, then row i of W from L W = I.
  std::vector<double> L(std::size_t(n) * std::size_t(n));
  for (int i = 0; i < n; ++i) {
    double pivot = covariance[at(i, i)];
    for (int j = 0; j < i; ++j) {
      double sum = covariance[at(i, j)];
      for (int k = 0; k < j; ++k) sum -= L[at(i, k)] * L[at(j, k)];
      L[at(i, j)] = sum * whitening[at(j, j)];
      pivot -= L[at(i, j)] * L[at(i, j)];
    }
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double inverse = 1.0 / std::sqrt(pivot);
    for (int j = 0; j < i; ++j) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum -= L[at(i, k)] * whitening[at(k, j)];
      whitening[at(i, j)] = sum * inverse;
    }
    whitening[at(i, i)] = inverse;
  }
  return true;
}

}  // namespace magimu::detail
