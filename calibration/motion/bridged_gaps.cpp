// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/bridged_gaps.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kMissing = 1.5;  // usual intervals: a sample is missing

}  // namespace

std::vector<double> gap_variances(const VectorSeries& series, const std::vector<double>& times) {
  std::vector<double> out;
  const double rate = series.rate_hz();
  if (rate <= 0.0 || times.size() < 2) return out;
  const double usual = 1.0 / rate;
  for (std::size_t k = 0; k + 1 < series.size(); ++k) {
    const double begin = series.t[k] + usual, end = series.t[k + 1];
    if (end - series.t[k] <= kMissing * usual) continue;
    const double missed = (series.v[k + 1] - series.v[k]).squaredNorm() / (4.0 * 3.0);
    auto i = std::size_t(
        std::max<std::ptrdiff_t>(0, std::ranges::upper_bound(times, begin) - times.begin() - 1));
    for (; i + 1 < times.size() && times[i] < end; ++i) {
      const double within = std::min(end, times[i + 1]) - std::max(begin, times[i]);
      if (within <= 0.0) continue;
      out.resize(times.size() - 1, 0.0);
      out[i] += missed * within * within;
    }
  }
  return out;
}

double with_gap(double density, const std::vector<double>& variances, std::size_t i,
                double seconds) {
  if (variances.empty() || variances[i] == 0.0) return density;
  return std::sqrt(density * density + variances[i] / seconds);
}

}  // namespace magimu
