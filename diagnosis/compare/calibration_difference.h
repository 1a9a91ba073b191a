// SPDX-License-Identifier: BSD-3-Clause
// Two calibrations of one device, group by group: what differs by how much, with the covariance
// that both give it (against.h says what the groups are).
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"

namespace magimu {

struct Difference {
  std::string group;
  std::vector<std::string> names;
  std::string unit;
  VectorXd d;              // b less a
  MatrixXd robust, model;  // covariances: robust, and what white noise would give
};

// Of the groups that both have.
std::vector<Difference> differences(const Calibration& a, const Calibration& b);

}  // namespace magimu
