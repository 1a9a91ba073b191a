// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/filter_samples.h"

#include <algorithm>

#include "calibration/motion/nodes.h"

namespace magimu {

std::vector<FilterStep> filter_steps(const Recording& recording) {
  const VectorSeries& gyr = recording.gyr;
  std::vector<double> times = gyr.t;
  times.insert(times.end(), recording.acc.t.begin(), recording.acc.t.end());
  for (const VectorSeries& mag : recording.mag) {
    times.insert(times.end(), mag.t.begin(), mag.t.end());
  }
  std::ranges::sort(times);
  std::vector<FilterStep> steps;
  std::size_t g = 0, a = 0;
  std::vector<std::size_t> next(recording.mag.size(), 0);
  for (const double t : times) {
    if (t < gyr.t.front() - kSameTime || t > gyr.t.back() + kSameTime) continue;
    if (!steps.empty() && t - steps.back().t < kSameTime) continue;
    FilterStep step;
    step.t = t;
    const auto reaches = [&](const VectorSeries& series, std::size_t& i) {
      while (i < series.size() && series.t[i] < t - kSameTime) ++i;
      return i < series.size() && series.t[i] <= t + kSameTime;
    };
    while (g + 1 < gyr.size() && gyr.t[g + 1] <= t + kSameTime) ++g;
    step.rate = gyr.v[g];
    if (reaches(recording.acc, a)) {
      step.has_acc = true;
      step.acc = recording.acc.v[a];
    }
    for (std::size_t m = 0; m < recording.mag.size(); ++m) {
      if (!reaches(recording.mag[m], next[m])) continue;
      step.mag.push_back({int(m), recording.mag[m].v[next[m]]});
    }
    if (!steps.empty()) steps.back().dt = t - steps.back().t;
    steps.push_back(std::move(step));
  }
  return steps;
}

}  // namespace magimu
