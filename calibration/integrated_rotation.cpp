// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/integrated_rotation.h"

#include <algorithm>

namespace magimu {

IntegratedRotation::IntegratedRotation(const VectorSeries& gyr, const Vector3& bias)
    : gyr_(gyr), bias_(bias) {
  attitude_.reserve(gyr.size());
  attitude_.emplace_back();
  for (std::size_t k = 0; k + 1 < gyr.size(); ++k) {
    const Vector3 v = (gyr.v[k] - bias) * (gyr.t[k + 1] - gyr.t[k]);
    attitude_.push_back((attitude_.back() * Rot3::Exp(v)).normalized());
  }
}

std::size_t IntegratedRotation::sample_at(double t) const {
  const auto it = std::upper_bound(gyr_.t.begin(), gyr_.t.end(), t);
  return it == gyr_.t.begin() ? 0 : std::size_t(it - gyr_.t.begin()) - 1;
}

Rot3 IntegratedRotation::at(double t) const {
  const std::size_t k = sample_at(t);
  return attitude_[k] * Rot3::Exp((gyr_.v[k] - bias_) * (t - gyr_.t[k]));
}

PreintegratedGyroscope IntegratedRotation::preintegrate(double a, double b) const {
  PreintegratedGyroscope out(bias_);
  std::size_t k = sample_at(a);
  double t = a;
  while (t < b) {
    const double end = k + 1 < gyr_.size() ? std::min(b, gyr_.t[k + 1]) : b;
    if (end > t) out.integrate(gyr_.v[k], end - t);
    t = std::max(t, end);
    ++k;
  }
  return out;
}

}  // namespace magimu
