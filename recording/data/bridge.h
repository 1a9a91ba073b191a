// SPDX-License-Identifier: BSD-3-Clause
// Single samples that a gyroscope lacks. Its readings are integrated: the rate before a hole, held
// on, turns every later attitude by the rate's change times the hole's length, many times what
// noise does. The cubic through two samples on either side of a short hole is wrong by less than
// noise, as long as the hole is short against the motion.
#pragma once

#include <vector>

#include "recording/data/recording.h"

namespace magimu {

inline constexpr int kLongestHole = 3;  // samples

// The series with holes of up to three samples filled: where samples were taken out, at their times
// (increasing), and where a sensor with a steady clock lacks some.
VectorSeries bridged(const VectorSeries& series, const std::vector<double>& taken_out);

}  // namespace magimu
