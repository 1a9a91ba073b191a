// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/sensor_rows.h"

#include "factors/keys.h"

namespace magimu {
namespace {

Sensor sensor_of(const FactorBatch& batch) {
  for (const Key key : batch.keys(0)) {
    if (key.symbol == key::mag_bias.symbol) return Sensor::kMag;
  }
  for (const Key key : batch.keys(0)) {
    if (key.symbol == key::gyr_bias.symbol) return Sensor::kGyr;
    if (key.symbol == key::acc_bias.symbol) return Sensor::kAcc;
  }
  return Sensor::kNone;
}

}  // namespace

SensorRows::SensorRows(const FactorGraph& graph, const LinearSystem& system)
    : sensor(std::size_t(system.rows()), Sensor::kNone),
      node(std::size_t(system.rows()), -1) {
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (batch.size() == 0) continue;
    const Sensor which = sensor_of(batch);
    for (int i = 0; i < batch.size(); ++i) {
      const Key first = batch.keys(i)[0];
      if (first.symbol != R(0).symbol) continue;  // a prior on a parameter
      for (int r = 0; r < batch.rows(); ++r) {
        const auto row = std::size_t(system.first_row(b) + i * batch.rows() + r);
        sensor[row] = which;
        node[row] = int(first.index);
      }
    }
  }
}

}  // namespace magimu
