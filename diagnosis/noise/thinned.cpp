// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/thinned.h"

#include <fmt/format.h>

#include "calibration/motion/rests/rests.h"
#include "calibration/motion/slower_recordings.h"

namespace magimu {
namespace {

constexpr double kLong = 6.0, kKeptRest = 4.0, kAtEnd = 3.0, kLeast = 20.0;  // s
// Sensors faster than the first are taken at the second or above.
constexpr double kFast = 150.0, kEnough = 75.0;  // Hz
constexpr SlowerRates kForSearch{kFast, kEnough};

}  // namespace

Recording without_long_rests(const Recording& recording, std::vector<std::string>& notes) {
  const double begin = recording.gyr.t.front(), end = recording.gyr.t.back();
  double from = begin, to = end;
  const std::vector<TimeSpan> rests = find_rests(recording);
  if (rests.empty()) return recording;
  const TimeSpan &first = rests.front(), &last = rests.back();
  if (first.begin_s < begin + kAtEnd && first.length_s() > kLong) from = first.end_s - kKeptRest;
  if (last.end_s > end - kAtEnd && last.length_s() > kLong) to = last.begin_s + kKeptRest;
  if (from == begin && to == end) return recording;
  if (to - from < kLeast) return recording;
  notes.push_back(fmt::format(
      "{}: the rests at its ends were cut to {:.0f} s each ({:.1f} to {:.1f} s are used): where a "
      "sensor is put down the field is another than where it is turned.",
      recording.name, kKeptRest, from, to));
  return slice(recording, from, to);
}

bool is_thinned(const VectorSeries& series) { return samples_in_one(series, kForSearch) > 1; }

Recording thinned(const Recording& recording) { return slower_recording(recording, kForSearch); }

}  // namespace magimu
