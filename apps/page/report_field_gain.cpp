// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report_field_gain.h"

#include <algorithm>
#include <cmath>

#include "calibration/use/apply.h"

namespace magimu::apps {
namespace {

struct Spread {
  double sum = 0.0, squares = 0.0, count = 0.0;

  void add(double value) {
    sum += value;
    squares += value * value;
    count += 1.0;
  }
  double mean() const { return sum / count; }
  double relative() const {
    return std::sqrt(std::max(0.0, squares / count - mean() * mean())) / mean();
  }
  double rms() const { return std::sqrt(squares / count); }
};

// Angle of the horizontal part from magnetic north, deg.
double heading_deg(const Vector3& field_n) { return std::atan2(field_n[0], field_n[1]) / kDegree; }

// The attitude at the node nearest to the time; null if that is kNear or more away.
const Rot3* attitude_at(const TrajectoryEstimate& path, double t) {
  constexpr double kNear = 0.05;  // s
  const auto after = std::ranges::lower_bound(path.t, t);
  std::size_t best = std::size_t(after - path.t.begin());
  if (best == path.t.size() || (best > 0 && t - path.t[best - 1] < path.t[best] - t)) {
    if (best == 0) return nullptr;
    --best;
  }
  return std::abs(path.t[best] - t) < kNear ? &path.nRb[best] : nullptr;
}

}  // namespace

FieldGain field_gain(const Calibration& c, const std::vector<const Recording*>& recordings,
                     std::size_t m) {
  Spread length_before, length_after, heading_before, heading_after;
  for (const Recording* r : recordings) {
    const VectorSeries& mag = r->mag[m];
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const Vector3 corrected = corrected_mag(c, m, mag.v[k]);
      length_before.add(mag.v[k].norm());
      length_after.add(corrected.norm());
      for (const TrajectoryEstimate& path : c.trajectories) {
        if (path.recording != r->name || path.t.empty()) continue;
        // A magnetometer that lags shows the attitude of a moment before.
        const Rot3* const nRb = attitude_at(path, mag.t[k] - mag_lag_s(c, m));
        if (nRb == nullptr) continue;
        heading_before.add(heading_deg(*nRb * mag.v[k]));
        heading_after.add(heading_deg(*nRb * corrected));
        break;
      }
    }
  }
  return {length_before.relative(), length_after.relative(), heading_before.rms(),
          heading_after.rms()};
}

}  // namespace magimu::apps
