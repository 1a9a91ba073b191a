// SPDX-License-Identifier: BSD-3-Clause
// Rows whose times go back, or far ahead for a moment: rows of two writers out of order, a damaged
// time, a counter that rolled over, a clock that was set. Internal to recording/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recording/data/times/row_times.h"

namespace magimu {

// Sensors that have rows of their own; the others may stand in the rows of every sensor.
inline constexpr std::uint32_t kOwnRows = RawRows::kVectors & ~RawRows::kPosition;
// Those of a row's sensors; all of them where none has.
inline std::uint32_t with_rows_of_their_own(std::uint32_t sensors) {
  const std::uint32_t own = sensors & kOwnRows;
  return own != 0 ? own : sensors;
}

// Above, in s, the spacing of doubles exceeds the distance at which two times are told apart
// (1e-10 s).
inline constexpr double kHugeTime = 1e6;

// Puts the times of `out`, one a row in s, on one clock: a counter's period is added after it
// rolled over, a new part begins where the clock was set, damaged times become NaN. Adds notes and
// cautions to `out`. Fails where the times go back for no reason that is known. usual_s: interval
// of rows.
void put_on_one_clock(const RawRows& rows, const RowTimesOptions& options, double usual_s,
                      const RowFailure& fail, RowTimes& out);

}  // namespace magimu
