// SPDX-License-Identifier: BSD-3-Clause
// In which unit a file's times are: the header's, if an IMU's rows come as often as in that unit;
// else the one unit in which an IMU's rows would. Internal to recording/.
#pragma once

#include <string>
#include <vector>

#include "recording/data/times/row_times.h"

namespace magimu {

// Intervals of an IMU's samples, s: below 1 Hz it cannot follow a hand, and above 10 kHz none
// delivers samples.
inline constexpr double kLeastInterval = 1e-4, kMostInterval = 1.0;
// Share of the rows. If more of them have the time of another row, the file is refused: that is no
// slip of single rows.
inline constexpr double kManyOfOneTime = 0.05;

// Mean interval between rows, in the column's unit; in a file with IMU samples between the rows
// that have one. The longest intervals are gaps and do not count. (The median would be the interval
// within a burst.) 0 if no time increases.
double usual_row_interval(const RawRows& rows);

// By what times in the header's unit are to be multiplied: 1 where the intervals fit that unit; the
// unit that they do fit over the header's where the column's name only suggested one. Fails where
// the header names a unit that the intervals contradict. usual: mean interval, s.
double unit_beside_header(const RawRows& rows, const RowTimesOptions& options, double usual,
                          const RowFailure& fail, std::vector<std::string>& notes);

// The unit of a column without one, in seconds; 1 where the numbers may be seconds. Fails where
// several units are possible, or none. usual: mean interval, in the column's unit.
double unit_of_times(const RawRows& rows, const RowTimesOptions& options, double usual,
                     const RowFailure& fail, std::vector<std::string>& notes);

}  // namespace magimu
