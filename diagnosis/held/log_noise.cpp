// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held/log_noise.h"

#include <algorithm>

#include "calibration/fit/marginal_likelihood.h"
#include "calibration/motion/sensor_rows.h"

namespace magimu {

std::vector<double> log_noise(const Stage& stage, const LinearSystem& system,
                              const std::vector<int>& window_of) {
  const SensorRows rows(stage.graph(), system);
  std::vector<double> out(std::size_t(std::ranges::max(window_of)) + 1, 0.0);
  for (std::size_t b = 0; b < stage.graph().batches().size(); ++b) {
    const FactorBatch& batch = *stage.graph().batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const auto row = std::size_t(system.first_row(b) + i * batch.rows());
      if (rows.sensor[row] == Sensor::kNone) continue;
      const int window = window_of[std::size_t(rows.node[row])];
      out[std::size_t(window)] -= log_det_whitening(batch, i);
    }
  }
  return out;
}

}  // namespace magimu
