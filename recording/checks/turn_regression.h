// SPDX-License-Identifier: BSD-3-Clause
// How fast a direction turns in a sensor's frame, against the gyroscope. A direction that is fixed
// in space obeys u' = -omega x u. Between two short blocks of readings that is linear in the
// gyroscope's readings: du = u x (M phi + b dt), phi the integral of the readings. M is the true
// rate over the reading, and turns the gyroscope's axes into the other sensor's. Nothing is assumed
// of units and axes, so that a wrong unit, a wrong range and swapped axes show as what they are.
#pragma once

#include <optional>

#include "recording/data/recording.h"

namespace magimu {

struct TurnRegression {
  double scale = 1.0;  // true rate over the gyroscope's reading: cube root of |det M|
  // Standard error of `scale`: from a jackknife over eight stretches of time, and from the unknown
  // bias of an accelerometer. (The bias is nearly all of it where gravity hardly turns in the
  // sensor.)
  double sigma = 0.0;
  double explained = 0.0;  // share of the squared changes of direction that the gyroscope explains
};

// `directions`: readings of a sensor that sees a direction fixed in space, in any unit.
// `offset_unknown`: estimate an offset of these readings (a magnetometer's bias). Empty if there
// are too few samples, or nothing turns. If the sensor did not turn about all three axes, M is
// assumed to be a multiple of the identity; swapped axes then show as a small `explained`.
std::optional<TurnRegression> regress_turns(const VectorSeries& gyr, const VectorSeries& directions,
                                            bool offset_unknown);

}  // namespace magimu
