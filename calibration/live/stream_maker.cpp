// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_maker.h"

#include <utility>

namespace magimu {

void StreamMaker::made(int window, const ModelSpec& spec) {
  biases.resize(std::size_t(window));
  const Vector3 &g = spec.gyr_bias, &a = spec.acc_bias;
  biases.push_back({g[0], g[1], g[2], a[0], a[1], a[2]});
  const std::vector<double> now = samples_.ends();
  ends.resize(std::size_t(window) * now.size());
  ends.insert(ends.end(), now.begin(), now.end());
}

bool StreamMaker::integrate_at(int window, const ModelSpec& spec, double gyr, double acc) {
  const Vector3 &g = spec.gyr_bias, &a = spec.acc_bias;
  Biases& b = biases[std::size_t(window)];
  const bool near = (Vector3(b[0], b[1], b[2]) - g).norm() <= gyr &&
                    (Vector3(b[3], b[4], b[5]) - a).norm() <= acc;
  if (!near) b = {g[0], g[1], g[2], a[0], a[1], a[2]};
  return !near;
}

WindowParts StreamMaker::again(int window) {
  const Biases& b = biases[std::size_t(window)];
  spec_.gyr_bias = Vector3(b[0], b[1], b[2]);
  spec_.acc_bias = Vector3(b[3], b[4], b[5]);
  const std::size_t sensors = ends.size() / biases.size();
  const std::span<const double> then(ends.data() + std::size_t(window) * sensors, sensors);
  WindowFactors f =
      window_factors(samples_, samples_.windows()[std::size_t(window)], spec_, nullptr, then);
  return {std::move(f.motion), std::move(f.field)};
}

IncrementalQrOptions estimator_options(std::shared_ptr<StreamMaker> maker, int awake) {
  IncrementalQrOptions out;
  out.is_global = is_calibration_global;
  out.awake = awake;
  out.make_again = [maker = std::move(maker)](int window) { return maker->again(window); };
  return out;
}

}  // namespace magimu
