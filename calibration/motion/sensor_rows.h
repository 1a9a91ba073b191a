// SPDX-License-Identifier: BSD-3-Clause
// Which sensor, and which node, each row of a calibration graph's linear system belongs to.
#pragma once

#include <array>
#include <vector>

#include "graph/linear_system.h"

namespace magimu {

// kReach: the weak measurements of position of a hand-held sensor. kNone: priors on parameters.
enum class Sensor { kAcc = 0, kGyr = 1, kMag = 2, kReach = 3, kNone = 4 };
inline constexpr std::size_t kSensors = 4;

struct SensorRows {
  // One entry a row of the system.
  std::vector<Sensor> sensor;
  std::vector<int> node;  // index of the factor's first pose; -1: none (a prior)
  std::vector<int> next;  // the same component of the next factor of its kind; -1: there is none

  SensorRows(const FactorGraph& graph, const LinearSystem& system);
};

// Per sensor, in the order of the enumeration.
struct SensorSums {
  std::array<double, kSensors> squares{};  // sum of squared whitened residuals
  std::array<double, kSensors> rows{};
  std::array<double, kSensors> absorbed{};  // degrees of freedom the fit has taken: tr(J P J')
  std::array<double, kSensors> lag1{};      // correlation of residuals at neighbouring nodes

  // Root mean square with the degrees of freedom that are left; 1 if the noise is as assumed.
  double rms(Sensor sensor) const;
};

}  // namespace magimu
