// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/residual_series.h"

#include <algorithm>

#include "calibration/motion/sensor_rows.h"

namespace magimu {

std::vector<ResidualSeries> residual_series(const Optimum& at,
                                            const std::vector<std::string>& mag_names) {
  const FactorGraph& graph = at.stage.graph();
  std::vector<double> times;
  for (const NodePlan& plan : at.stage.plans()) {
    times.insert(times.end(), plan.t.begin(), plan.t.end());
  }
  std::vector<ResidualSeries> out(2 + mag_names.size());
  out[0].sensor = "acc";
  out[1].sensor = "gyr";
  for (std::size_t m = 0; m < mag_names.size(); ++m) out[2 + m].sensor = mag_names[m];

  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const int first = at.system.first_row(b) + i * batch.rows();
      auto seen = Sensor::kNone;
      for (int row = first; row + 2 < first + batch.rows(); row += 3) {
        const Sensor sensor = at.rows.sensor[std::size_t(row)];
        const int node = at.rows.node[std::size_t(row)];
        if (node < 0 || sensor > Sensor::kMag || sensor == seen) continue;
        seen = sensor;
        const std::size_t which = sensor == Sensor::kMag
                                      ? std::size_t(2 + magnetometer_of(batch.keys(i)))
                                      : std::size_t(sensor);
        if (which >= out.size()) continue;
        out[which].t.push_back(times[std::size_t(node)]);
        out[which].whitened.push_back(at.system.residual().segment<3>(row));
      }
    }
  }
  return out;
}

}  // namespace magimu
