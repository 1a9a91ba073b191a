// SPDX-License-Identifier: BSD-3-Clause
// A slower sensor whose readings a logger has put onto straight lines between them, at the times of
// its rows. In a row's interval in which two lines meet at tau, the slope changes at the row before
// and at the one after in the same direction, by shares that tell tau:
//
//   e_k = (1 - w) (B - A),  e_k+1 = w (B - A),  tau = t_k + w (t_k+1 - t_k),
//
// with the slopes A and B of the lines, and e_k what the slope changes by at sample k. Measured
// samples change theirs in directions of their own. So the readings come back, with their times,
// wherever each line has two samples or more.
#pragma once

#include <optional>

#include "recording/data/recording.h"

namespace magimu {

// The readings between which all samples were interpolated, with the times at which the lines meet.
// Nothing where the samples are not such: some do not fit, or they follow a smooth curve.
std::optional<VectorSeries> readings_of_lines(const VectorSeries& series);

}  // namespace magimu
