// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/acc_jitter.h"

#include <algorithm>
#include <cmath>

namespace magimu {

std::vector<double> acc_densities(const VectorSeries& acc, const std::vector<double>& times,
                                  double density, double jitter) {
  std::vector<double> out(times.size(), density);
  if (!(jitter > 0.0) || acc.size() < 2) return out;
  const double h = 1.0 / acc.rate_hz(), at_rest = 2.0 * density * density / h;
  std::size_t k = 1;
  for (std::size_t i = 1; i < times.size(); ++i) {
    while (k + 1 < acc.size() && acc.t[k] <= times[i - 1]) ++k;
    // The steps into the samples of the interval; without any, the step across it.
    const std::size_t first = k;
    while (k + 1 < acc.size() && acc.t[k + 1] <= times[i]) ++k;
    double sum = 0.0;
    for (std::size_t j = first; j <= k; ++j) sum += (acc.v[j] - acc.v[j - 1]).squaredNorm() / 3.0;
    const double steps = std::max(0.0, sum / double(k + 1 - first) - at_rest);
    out[i] = std::sqrt(density * density + jitter * jitter * h * steps);
  }
  return out;
}

}  // namespace magimu
