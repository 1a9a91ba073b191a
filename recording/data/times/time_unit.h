// SPDX-License-Identifier: BSD-3-Clause
// In which unit a file's times are: what its header says, if rows then come as often as those of an
// IMU, else the unit in which they do. Internal to recording/.
#pragma once

#include <string>
#include <vector>

#include "recording/data/times/row_times.h"

namespace magimu {

// Intervals of an IMU's samples, s: below 1 Hz it cannot follow a hand, and above 10 kHz none
// delivers samples.
inline constexpr double kLeastInterval = 1e-4, kMostInterval = 1.0;
// Of the rows; more of them with the time of another row are no slip.
inline constexpr double kManyOfOneTime = 0.05;

// Mean interval of rows, in the column's unit, of those with an IMU sample where there are any; the
// longest ones, gaps, do not count. (The median would be the interval within a burst.) 0 if no time
// increases.
double usual_row_interval(const RawRows& rows);

// The unit of a column that its header names, over the unit that its intervals show: 1 where both
// agree, else what the times are to be multiplied by, where the name only suggested the unit. Fails
// where the header names another unit than the column has. usual: of the intervals, s.
double unit_beside_header(const RawRows& rows, const RowTimesOptions& options, double usual,
                          const RowFailure& fail, std::vector<std::string>& notes);

// Seconds that the numbers are given in; 1 where they may be seconds. Fails where several units are
// possible, or none. usual: of the intervals, in the column's unit.
double unit_of_times(const RawRows& rows, const RowTimesOptions& options, double usual,
                     const RowFailure& fail, std::vector<std::string>& notes);

}  // namespace magimu
