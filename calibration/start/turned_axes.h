// SPDX-License-Identifier: BSD-3-Clause
// Did the sensor turn about more than one axis? A direction of n that keeps still in the IMU frame
// is the only axis it turned about: the mean of R' leaves that direction its length and shortens
// all others.
#pragma once

#include <optional>
#include <vector>

#include "graph/rot3.h"

namespace magimu {

struct TurnedAxes {
  bool enough = false;          // turned about two axes at least, by more than a few degrees
  bool hardly_more = false;     // enough, but by less than twice as much
  std::optional<Vector3> only;  // not enough, but about this axis (IMU frame); empty: hardly at all
};

// nRb: attitudes of all recordings.
TurnedAxes turned_axes(const std::vector<Rot3>& nRb);

// Why a calibration from such a motion is worth nothing, and what to do; empty where it turned
// enough.
std::string turned_too_little(const TurnedAxes& turned);

}  // namespace magimu
