// SPDX-License-Identifier: BSD-3-Clause
// Which sensor, and which node, each row of a calibration graph's linear system belongs to.
#pragma once

#include <array>
#include <vector>

#include "graph/linear_system.h"

namespace magimu {

enum class Sensor { kAcc = 0, kGyr = 1, kMag = 2, kNone = 3 };

struct SensorRows {
  // row.size() = rows of the system.
  std::vector<Sensor> sensor;
  std::vector<int> node;  // index of the factor's first pose; -1: none (a prior)

  SensorRows(const FactorGraph& graph, const LinearSystem& system);
};

// Per sensor: acc, gyr, mag.
struct SensorSums {
  std::array<double, 3> squares{};  // sum of squared whitened residuals
  std::array<double, 3> rows{};
  std::array<double, 3> absorbed{};  // degrees of freedom the fit has taken: tr(J P J')
  std::array<double, 3> lag1{};      // correlation of residuals at neighbouring nodes
};

}  // namespace magimu
