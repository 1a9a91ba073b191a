// SPDX-License-Identifier: BSD-3-Clause
#include "apps/residual_of_field.h"

#include <algorithm>
#include <cmath>

#include "calibration/apply.h"

namespace magimu::apps {
namespace {

// The attitude between two nodes: turned steadily from one to the next.
Rot3 attitude_at(const TrajectoryEstimate& trajectory, double t) {
  const auto next = std::lower_bound(trajectory.t.begin(), trajectory.t.end(), t);
  const auto i = std::size_t(next - trajectory.t.begin());
  if (i == 0) return trajectory.nRb.front();
  if (i == trajectory.t.size()) return trajectory.nRb.back();
  const double share = (t - trajectory.t[i - 1]) / (trajectory.t[i] - trajectory.t[i - 1]);
  const Rot3& from = trajectory.nRb[i - 1];
  return from * Rot3::Exp(Vector3(share * (from.inverse() * trajectory.nRb[i]).Log()));
}

}  // namespace

ResidualTrace field_residuals(const Calibration& c, const std::vector<const Recording*>& recordings,
                              std::size_t m) {
  ResidualTrace out;
  const double lag = mag_lag_s(c, m);
  for (std::size_t r = 0; r < std::min(recordings.size(), c.trajectories.size()); ++r) {
    const TrajectoryEstimate& trajectory = c.trajectories[r];
    const VectorSeries own = without_repeats(recordings[r]->mag[m]);
    const bool repeats = double(own.size()) < 0.7 * double(recordings[r]->mag[m].size());
    const VectorSeries& mag = repeats ? own : recordings[r]->mag[m];
    const double dip = r < c.fields.size() ? c.fields[r].dip_rad : c.parameters.dip_rad;
    const double rate = mag.rate_hz();
    std::size_t k = 0;
    for (std::size_t node = 0; node + 1 < trajectory.t.size(); ++node) {
      // Samples that show the attitudes up to half of the way to the next node.
      const double end = 0.5 * (trajectory.t[node] + trajectory.t[node + 1]) + lag;
      Vector3 sum = Vector3::Zero();
      int n = 0;
      for (; k < mag.size() && mag.t[k] < end; ++k) {
        const Rot3 nRb = attitude_at(trajectory, mag.t[k] - lag);
        sum += mag.v[k] - magnetometer_model(nRb, c.parameters.mag[m].distortion,
                                             c.parameters.mag[m].bias, dip);
        ++n;
      }
      if (n == 0 || node == 0) continue;  // before the first node samples are many and far away
      out.t.push_back(trajectory.t[node]);
      out.before.push_back(sum / n / (c.noise.mag * std::sqrt(rate / n)));
    }
  }
  return out;
}

}  // namespace magimu::apps
