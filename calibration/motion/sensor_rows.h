// SPDX-License-Identifier: BSD-3-Clause
// Which sensor, and which node, each row of a calibration graph's linear system belongs to.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "graph/linear_system.h"
#include "graph/sensor.h"

namespace magimu {

struct SensorRows {
  // One entry a row of the system.
  std::vector<Sensor> sensor;
  std::vector<int> node;  // index of the factor's first pose; -1: none (a prior)
  std::vector<int> next;  // the same component of the next factor of its kind; -1: there is none
  std::vector<std::int16_t> magnetometer;  // which one, of kMag; else -1

  SensorRows(const FactorGraph& graph, const LinearSystem& system);
};

// The magnetometer that a factor with these keys belongs to; -1: none.
int magnetometer_of(std::span<const Key> keys);

// Of the rows of one magnetometer.
struct MagnetometerSums {
  double squares = 0.0;   // of whitened residuals
  double rows = 0.0;      // how many
  double absorbed = 0.0;  // degrees of freedom the fit has taken
  double lag1 = 0.0;      // correlation of residuals at neighbouring nodes

  // As SensorSums::rms().
  double rms() const;
};

// Per sensor, in the order of the enumeration; of the reach, too.
struct SensorSums {
  std::array<double, kMeasuring> squares{};  // sum of squared whitened residuals
  std::array<double, kMeasuring> rows{};
  std::array<double, kMeasuring> absorbed{};    // degrees of freedom the fit has taken: tr(J P J')
  std::array<double, kMeasuring> lag1{};        // correlation of residuals at neighbouring nodes
  std::vector<MagnetometerSums> magnetometers;  // each by itself; empty where there is one

  // Root mean square with the degrees of freedom that are left; 1 if the noise is as assumed. At
  // least a fiftieth of the rows counts as left: of fewer it is below 1.
  double rms(Sensor sensor) const;
  // Of a sensor's rows, the share that the fit has left free: 1 where it follows other sensors.
  double freedom(Sensor sensor) const;
};

}  // namespace magimu
