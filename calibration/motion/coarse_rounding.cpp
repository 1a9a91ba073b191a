// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/coarse_rounding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "recording/checks/rounding.h"

namespace magimu {
namespace {

constexpr double kOneStep = 1.5;  // steps: above one and below two

// Squared densities of one axis at each sample, unit^2/Hz; empty: none. Errors are even over a
// step, of variance step^2 / 12, and last as long as the reading stays within a step: a little
// noise takes it to and fro between two, and leaves most of the error.
std::vector<double> squared_densities(const VectorSeries& series) {
  std::vector<double> out;
  const std::optional<Vector3> step = coarse_steps(series);
  if (!step) return out;
  out.resize(series.size(), 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const double square = (*step)[axis] * (*step)[axis] / 12.0 / 3.0;
    std::size_t begin = 0;
    double low = series.v.front()[axis], high = low;
    for (std::size_t k = 0; k < series.size(); ++k) {
      const bool last = k + 1 == series.size();
      if (!last) {
        const double next = series.v[k + 1][axis];
        low = std::min(low, next);
        high = std::max(high, next);
        if (high - low < kOneStep * (*step)[axis]) continue;
        low = high = next;
      }
      const double lasted = series.t[last ? k : k + 1] - series.t[begin];
      for (; begin <= k; ++begin) out[begin] += square * lasted;
    }
  }
  return out;
}

}  // namespace

void add_rounding(const VectorSeries& series, const std::vector<double>& times,
                  std::vector<double>& variances) {
  const std::vector<double> square = squared_densities(series);
  if (square.empty() || times.size() < 2) return;
  variances.resize(times.size() - 1, 0.0);
  std::size_t i = 0;
  for (std::size_t k = 0; k + 1 < series.size(); ++k) {
    while (i + 2 < times.size() && times[i + 1] <= series.t[k]) ++i;
    for (std::size_t j = i; j + 1 < times.size() && times[j] < series.t[k + 1]; ++j) {
      const double within =
          std::min(series.t[k + 1], times[j + 1]) - std::max(series.t[k], times[j]);
      variances[j] += square[k] * std::max(0.0, within);
    }
  }
}

std::vector<double> rounding_of_means(const VectorSeries& series,
                                      const std::vector<NodeMean>& means) {
  const std::vector<double> square = squared_densities(series);
  std::vector<double> out;
  if (square.empty()) return out;
  for (const NodeMean& mean : means) {
    double sum = 0.0;
    for (int k = 0; k < mean.count; ++k) sum += square[std::size_t(mean.first) + std::size_t(k)];
    out.push_back(sum * series.rate_hz() / std::max(1.0, double(mean.count) * mean.count));
  }
  return out;
}

}  // namespace magimu
