// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/noise_by_rate.h"

#include <algorithm>
#include <cmath>

#include "calibration/motion/integrated_rotation.h"
#include "diagnosis/noise/noise_causes.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kRateBlock = 2.0;  // s: longer than the correlation time of noise
constexpr int kFewestBlocks = 10;   // whose scatter gives a standard deviation

double mean_of(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) sum += x[i];
  return sum / double(std::max<std::size_t>(1, end - begin));
}

}  // namespace

NoiseByRate noise_by_rate(const ResidualSeries& series, const Recording& recording) {
  NoiseByRate out;
  const std::size_t n = series.t.size();
  if (n < kLeastSamples) return out;
  const IntegratedRotation gyr(recording.gyr, Vector3::Zero());
  std::vector<double> rate, square;
  for (std::size_t k = 0; k < n; ++k) {
    rate.push_back(gyr.rate(series.t[k]).norm());
    square.push_back(series.whitened[k].squaredNorm());
  }
  const double mean_rate = mean_of(rate, 0, n), mean_square = mean_of(square, 0, n);
  if (!(mean_square > 0.0)) return out;
  // The score of a variance that grows with the rate, in blocks.
  double score = 0.0, in_block = 0.0, squares = 0.0, spread = 0.0, begin = series.t.front();
  int blocks = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if (series.t[k] - begin > kRateBlock) {
      squares += in_block * in_block;
      in_block = 0.0;
      begin = series.t[k];
      ++blocks;
    }
    const double x = rate[k] - mean_rate, s = x * (square[k] / mean_square - 1.0);
    in_block += s;
    score += s;
    spread += x * x;
  }
  squares += in_block * in_block;
  if (blocks < kFewestBlocks || !(squares > 0.0) || !(spread > 0.0)) return out;
  // |r|^2 over its mean has the variance 2/3.
  out.statistic = score * score / (spread * 2.0 / 3.0);
  if (score > 0.0) {
    out.log10_p = log10_student_tail(score / std::sqrt(squares), blocks);
  }
  std::vector<std::size_t> order(n);
  for (std::size_t k = 0; k < n; ++k) order[k] = k;
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return rate[k]; });
  std::vector<double> sorted;
  for (const std::size_t k : order) sorted.push_back(square[k]);
  out.fast_over_slow =
      std::sqrt(mean_of(sorted, n - n / 3, n) / std::max(mean_of(sorted, 0, n / 3), 1e-300));
  return out;
}

}  // namespace magimu
