// SPDX-License-Identifier: BSD-3-Clause
// Rates, durations and slices of recordings.
#include "recording/data/recording.h"

#include <algorithm>
#include <utility>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kGapOfRows = 2.5;  // usual intervals: a lost row makes two of them

// The samples first <= k < last: those with t0 <= t < t1.
struct Range {
  std::ptrdiff_t first, last;

  Range(const std::vector<double>& t, double t0, double t1)
      : first(std::lower_bound(t.begin(), t.end(), t0) - t.begin()),
        last(std::max(first, std::lower_bound(t.begin(), t.end(), t1) - t.begin())) {}

  // A member that a file lacks is an empty vector, and stays one.
  template <class T>
  std::vector<T> of(const std::vector<T>& v) const {
    if (v.empty()) return {};
    return std::vector<T>(v.begin() + first, v.begin() + last);
  }
};

constexpr double kShortestInterval = 2e-5;  // s: no part is read more often

template <class Series>
Series slice(const Series& series, double t0, double t1) {
  const Range range(series.t, t0, t1);
  return {range.of(series.t), range.of(series.v)};
}

MotionTruth slice(const MotionTruth& truth, double t0, double t1) {
  const Range range(truth.t, t0, t1);
  return {range.of(truth.t), range.of(truth.nRb), range.of(truth.position), range.of(truth.valid),
          range.of(truth.moving)};
}

}  // namespace

double VectorSeries::rate_hz() const {
  if (t.size() < 2) return 0.0;
  std::vector<double> intervals(t.size() - 1);
  for (std::size_t k = 0; k + 1 < t.size(); ++k) intervals[k] = t[k + 1] - t[k];
  const double usual = median(std::move(intervals));
  // Stamped when they arrived, several at once: then the usual interval is that of the reader's
  // loop.
  const double mean = (t.back() - t.front()) / double(t.size() - 1);
  return 1.0 / (usual < kShortestInterval ? std::max(usual, mean) : usual);
}

double Recording::duration_s() const {
  if (acc.empty() && gyr.empty()) return 0.0;
  if (acc.empty()) return gyr.t.back() - gyr.t.front();
  if (gyr.empty()) return acc.t.back() - acc.t.front();
  return std::max(acc.t.back(), gyr.t.back()) - std::min(acc.t.front(), gyr.t.front());
}

VectorSeries without_repeats(const VectorSeries& series) {
  const double rate = series.rate_hz();
  NewReadings are_new(rate > 0.0 ? 1.0 / rate : 0.0);
  VectorSeries out;
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (are_new(series.t[k], series.v[k])) out.push_back(series.t[k], series.v[k]);
  }
  return out;
}

bool NewReadings::operator()(double t, const Vector3& v) {
  const bool first = !(last_t_ > -std::numeric_limits<double>::infinity());
  const bool repeats = !first && v == last_v_;
  const bool after_gap = !first && t - last_t_ > kGapOfRows * usual_s_;
  last_t_ = t;
  last_v_ = v;
  return first || (!repeats && !after_gap);
}

Recording slice(const Recording& recording, double t0, double t1) {
  Recording part;
  part.name = recording.name;
  part.acc = slice(recording.acc, t0, t1);
  part.gyr = slice(recording.gyr, t0, t1);
  for (const VectorSeries& mag : recording.mag) part.mag.push_back(slice(mag, t0, t1));
  part.mag_names = recording.mag_names;
  for (const auto& [name, series] : recording.aux) part.aux[name] = slice(series, t0, t1);
  if (recording.pos) part.pos = slice(*recording.pos, t0, t1);
  if (recording.truth) part.truth = slice(*recording.truth, t0, t1);
  part.notes = recording.notes;
  part.cautions = recording.cautions;
  part.file_units = recording.file_units;
  part.set_aside = recording.set_aside;
  part.continues_previous = recording.continues_previous;
  return part;
}

const VectorSeries& series_of(const Recording& recording, Sensor sensor) {
  if (sensor == Sensor::kAcc) return recording.acc;
  return sensor == Sensor::kGyr ? recording.gyr : recording.mag.front();
}
VectorSeries& series_of(Recording& recording, Sensor sensor) {
  return const_cast<VectorSeries&>(series_of(std::as_const(recording), sensor));
}

void convert_gyro_interval(Recording& recording, GyroInterval convention) {
  const double rate = recording.gyr.rate_hz();
  if (convention == GyroInterval::kForward || rate <= 0.0) return;
  const double shift = (convention == GyroInterval::kCentred ? 0.5 : 1.0) / rate;
  for (double& t : recording.gyr.t) t -= shift;
}

}  // namespace magimu
