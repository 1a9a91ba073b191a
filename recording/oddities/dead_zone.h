// SPDX-License-Identifier: BSD-3-Clause
// A gyroscope with a dead band: for small rates its device writes one reading, 0 or a constant.
// That is neither a sample that is missing nor a sensor that hangs: readings come down to the same
// smallest distance from that one before they are it, and none lies between.
#pragma once

#include <optional>

#include "recording/data/recording.h"

namespace magimu {

struct DeadZone {
  Vector3 reads;      // within the band; not a number: this axis has none
  double edge = 0.0;  // smallest distance of all other readings from it, rad/s

  // Is that a reading with all axes within?
  bool holds(const Vector3& v) const { return v == reads; }
};
std::optional<DeadZone> dead_zone_of(const VectorSeries& gyr);

}  // namespace magimu
