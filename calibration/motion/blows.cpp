// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/blows.h"

#include <algorithm>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kBlow = 20.0;     // m/s^2, second difference
constexpr double kTogether = 0.1;  // s
constexpr double kAround = 1.0;    // s
// Times the median around. That of a normal vector is 1.54 standard deviations of an axis; in 1e7
// of them none is longer than 5.9. A vibration's largest are 1.4 to 2 times its median.
constexpr double kStandsOut = 4.0;

}  // namespace

double blows_per_minute(const Recording& recording) {
  const VectorSeries& acc = recording.acc;
  if (acc.size() < 3) return 0.0;
  std::vector<double> bends;  // of acc.v[k + 1]
  for (std::size_t k = 1; k + 1 < acc.size(); ++k) {
    bends.push_back((acc.v[k - 1] - 2.0 * acc.v[k] + acc.v[k + 1]).norm());
  }
  const auto second_of = [&](std::size_t k) {
    return std::size_t(std::clamp((acc.t[k] - acc.t.front()) / kAround, 0.0, 1e7));
  };
  std::vector<double> usual(second_of(acc.size() - 1) + 3, 0.0);
  for (std::size_t begin = 1; begin + 1 < acc.size();) {
    std::size_t end = begin;
    while (end + 1 < acc.size() && second_of(end) == second_of(begin)) ++end;
    usual[second_of(begin) + 1] = median(std::vector<double>(
        bends.begin() + std::ptrdiff_t(begin - 1), bends.begin() + std::ptrdiff_t(end - 1)));
    begin = end;
  }
  int blows = 0;
  double last = -1e30;
  for (std::size_t k = 1; k + 1 < acc.size(); ++k) {
    const std::size_t s = second_of(k);
    const double around = std::max({usual[s], usual[s + 1], usual[s + 2]});
    if (bends[k - 1] < std::max(kBlow, kStandsOut * around)) continue;
    if (acc.t[k] > last + kTogether) ++blows;
    last = acc.t[k];
  }
  const double minutes = recording.duration_s() / 60.0;
  return minutes > 0.0 ? blows / minutes : 0.0;
}

}  // namespace magimu
