// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/sensor_rows.h"

#include <algorithm>
#include <cmath>

#include "factors/keys.h"

namespace magimu {
namespace {

bool has(std::span<const Key> keys, char symbol) {
  return std::any_of(keys.begin(), keys.end(), [&](Key k) { return k.symbol == symbol; });
}

// The sensor of one row of a batch's factors.
Sensor sensor_of(std::span<const Key> keys, int row) {
  if (has(keys, key::mag_bias.symbol)) return Sensor::kMag;
  const bool gyr = has(keys, key::gyr_bias.symbol), acc = has(keys, key::acc_bias.symbol);
  if (gyr && acc) return row < 3 ? Sensor::kGyr : Sensor::kAcc;  // PreintegratedImuFactor
  if (gyr) return Sensor::kGyr;
  if (acc) return Sensor::kAcc;
  return has(keys, P(0).symbol) || has(keys, V(0).symbol) ? Sensor::kReach : Sensor::kNone;
}

constexpr double kLeastLeft = 0.02;  // of the rows: fewer tell what the model lacks, not noise

// Root mean square of so many residuals, with the degrees of freedom that are left.
double rms_of(double squares, double rows, double absorbed) {
  const double left = std::max(rows - absorbed, kLeastLeft * rows);
  return left > 0.0 ? std::sqrt(squares / left) : 1.0;
}

}  // namespace

SensorRows::SensorRows(const FactorGraph& graph, const LinearSystem& system)
    : sensor(std::size_t(system.rows()), Sensor::kNone),
      node(std::size_t(system.rows()), -1),
      next(std::size_t(system.rows()), -1),
      magnetometer(std::size_t(system.rows()), -1) {
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const Key first = batch.keys(i)[0];
      if (first.symbol != R(0).symbol && first.symbol != P(0).symbol) continue;
      const auto own = std::int16_t(magnetometer_of(batch.keys(i)));
      for (int r = 0; r < batch.rows(); ++r) {
        const int row = system.first_row(b) + i * batch.rows() + r;
        sensor[std::size_t(row)] = sensor_of(batch.keys(i), r);
        node[std::size_t(row)] = int(first.index);
        magnetometer[std::size_t(row)] = own;
        if (i + 1 < batch.size()) next[std::size_t(row)] = row + batch.rows();
      }
    }
  }
}

int magnetometer_of(std::span<const Key> keys) {
  const auto bias = std::ranges::find(keys, key::mag_bias.symbol, &Key::symbol);
  return bias == keys.end() ? -1 : int(bias->index) % 1000;  // keys.h: 1000 and more of changes
}

double MagnetometerSums::rms() const { return rms_of(squares, rows, absorbed); }

double SensorSums::rms(Sensor sensor) const {
  const auto s = std::size_t(sensor);
  return rms_of(squares[s], rows[s], absorbed[s]);
}

double SensorSums::freedom(Sensor sensor) const {
  const auto s = std::size_t(sensor);
  return rows[s] > 0.0 ? std::clamp(1.0 - absorbed[s] / rows[s], 0.0, 1.0) : 0.0;
}

}  // namespace magimu
