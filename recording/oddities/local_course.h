// SPDX-License-Identifier: BSD-3-Clause
// What the neighbours of a reading say that it should be: the polynomial through them by least
// squares, without the one of them that fits it worst, for that may be garbage itself.
//
// With four neighbours at either side it is a cubic. What it says of white noise has a variance of
// 0.34 of a sample's, so that the reading less its prediction has 1.16 standard deviations: nearly
// all that a fit of the whole recording could tell. What it misses of a field that turns at w, in
// samples dt apart, is of the fourth order: 6 uT of 50 for w dt = 1 and 0.005 uT for 0.17, which is
// 10 rad/s at 60 Hz. So the gyroscope is not needed to turn the neighbours' readings.
#pragma once

#include <span>

#include "graph/rot3.h"

namespace magimu {

struct LocalCourse {
  // The course at time 0.
  Vector3 middle;
  // Range of the neighbours about the course, scaled to that of as many independent numbers with
  // the standard deviation of (reading - middle).
  Vector3 spread;
};

inline constexpr std::size_t kMostNeighbours = 8;

// Neighbours at these times, 4 to kMostNeighbours of them, at least two of them different, from the
// time 0.
LocalCourse local_course(std::span<const double> t, std::span<const Vector3* const> v);

}  // namespace magimu
