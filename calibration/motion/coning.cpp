// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/coning.h"

#include "calibration/motion/sample_times.h"

namespace magimu {
namespace {

// h^2 / 12 w x w' of sample k.
Vector3 coning_of(const VectorSeries& s, std::size_t k) {
  if (!is_evenly_spaced(s.t, k)) return Vector3::Zero();
  const double h = s.t[k + 1] - s.t[k], both = s.t[k + 1] - s.t[k - 1];
  return s.v[k].cross(s.v[k + 1] - s.v[k - 1]) * (h * h / (12.0 * both));
}

}  // namespace

VectorSeries constant_rates(const VectorSeries& means) {
  VectorSeries out = means;
  for (std::size_t k = 0; k < means.size(); ++k) out.v[k] += coning_of(means, k);
  return out;
}

double squares_of_coning(const VectorSeries& means, double density) {
  double sum = 0.0;
  for (std::size_t k = 0; k < means.size(); ++k) sum += coning_of(means, k).squaredNorm();
  const double variance = density * density * means.rate_hz();
  return variance > 0.0 ? sum / variance : 0.0;
}

}  // namespace magimu
