// SPDX-License-Identifier: BSD-3-Clause
// Which orientations a recording went through, and in words which are missing: a calibration knows
// a sensor only in the attitudes in which it has seen it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "graph/rot3.h"
#include "recording/data/recording.h"

namespace magimu {

struct Coverage {
  // Shares of all directions, 0 to 1, that came within 20 degrees of "up", and of the field, in
  // the sensor's frame.
  double up = 0.0, field = 0.0;
  // Smallest angle between "up" and the axes x, -x, y, -y, z, -z, rad.
  std::array<double, 6> nearest_up_rad{};
  Vector3 turned_rad = Vector3::Zero();  // about x, y, z, to and fro added up
  double fastest_rad_s = 0.0;
  std::vector<std::string> missing;  // sentences: what to add; empty: nothing
};

// parts: of one recording (recording/data/parts.h). nRb: attitudes, some a second. dip_rad and
// gyr_bias: roughly.
Coverage coverage_of(const std::vector<const Recording*>& parts, const std::vector<Rot3>& nRb,
                     double dip_rad, const Vector3& gyr_bias);

}  // namespace magimu
