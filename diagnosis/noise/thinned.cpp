// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/thinned.h"

#include <fmt/format.h>

#include "calibration/motion/rests.h"

namespace magimu {
namespace {

constexpr double kLong = 6.0, kKeptRest = 4.0, kAtEnd = 3.0, kLeast = 20.0;  // s
constexpr double kFast = 150.0, kEnough = 75.0;                              // Hz

VectorSeries means(const VectorSeries& series, bool time_of_first) {
  if (!is_thinned(series)) return series;
  const auto n = std::size_t(series.rate_hz() / kEnough);
  VectorSeries out;
  for (std::size_t k = 0; k + n <= series.size(); k += n) {
    double t = 0.0;
    Vector3 v = Vector3::Zero();
    for (std::size_t i = k; i < k + n; ++i) {
      t += series.t[i] / double(n);
      v += series.v[i] / double(n);
    }
    out.push_back(time_of_first ? series.t[k] : t, v);
  }
  return out;
}

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

bool is_thinned(const VectorSeries& series) { return series.rate_hz() > kFast; }

Recording thinned(const Recording& recording) {
  Recording out = recording;
  out.acc = means(recording.acc, false);
  out.gyr = means(recording.gyr, true);
  for (VectorSeries& mag : out.mag) mag = means(mag, false);
  return out;
}

}  // namespace magimu
