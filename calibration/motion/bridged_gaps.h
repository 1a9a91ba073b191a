// SPDX-License-Identifier: BSD-3-Clause
// Gaps of an inertial sensor that are bridged (recording/data/parts.h has those that are not): its
// last sample before the gap is held. What that misses is known from the first sample after it:
// half of the change in between, if it came evenly.
#pragma once

#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// Variance of one axis that gaps add to the integral of the series between each two of these times
// (s; entry i: from i to i + 1), such as rad^2 of a gyroscope's turn. Empty where there are none.
std::vector<double> gap_variances(const VectorSeries& series, const std::vector<double>& times);

// A density, per sqrt(Hz), with such a variance over `seconds`.
double with_gap(double density, const std::vector<double>& variances, std::size_t i,
                double seconds);

}  // namespace magimu
