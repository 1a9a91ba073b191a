// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/orientation_error.h"

#include <algorithm>

namespace magimu {

OrientationError orientation_error(const TrajectoryEstimate& estimate, const MotionTruth& truth) {
  constexpr double kNearestTruth = 0.01;  // s
  OrientationError out;
  double total = 0.0, heading = 0.0, inclination = 0.0;
  std::size_t j = 0;
  for (std::size_t k = 0; k < estimate.t.size(); ++k) {
    const double t = estimate.t[k];
    while (j + 1 < truth.t.size() && std::abs(truth.t[j + 1] - t) <= std::abs(truth.t[j] - t)) ++j;
    if (j >= truth.t.size() || std::abs(truth.t[j] - t) > kNearestTruth || !truth.valid[j])
      continue;
    const Rot3 error = estimate.nRb[k] * truth.nRb[j].inverse();
    const Vector4& q = error.quaternion();
    total += error.Log().squaredNorm();
    heading += std::pow(2.0 * std::atan2(std::abs(q[3]), std::abs(q[0])), 2);
    inclination += std::pow(2.0 * std::asin(std::min(1.0, std::hypot(q[1], q[2]))), 2);
    ++out.compared;
  }
  if (out.compared == 0) return out;
  const auto rms_deg = [&](double sum) { return std::sqrt(sum / out.compared) / kDegree; };
  out.total_deg = rms_deg(total);
  out.heading_deg = rms_deg(heading);
  out.inclination_deg = rms_deg(inclination);
  return out;
}

}  // namespace magimu
