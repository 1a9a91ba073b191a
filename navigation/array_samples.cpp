// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/array_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "recording/data/error.h"

namespace magimu {
namespace {

// Between samples that are further apart, in usual intervals, nothing is interpolated.
constexpr double kLongestInterval = 2.5;

// Interpolates a series at times that increase from call to call.
class Interpolator {
 public:
  explicit Interpolator(const VectorSeries& series) : series_(series) {
    longest_ = kLongestInterval / series.rate_hz();
  }
  // Linear between the neighbours; nothing outside, or in a gap.
  std::optional<Vector3> at(double t) {
    while (next_ < series_.size() && series_.t[next_] < t) ++next_;
    if (next_ == series_.size()) return std::nullopt;
    if (series_.t[next_] == t) return series_.v[next_];
    if (next_ == 0) return std::nullopt;
    const double before = series_.t[next_ - 1], width = series_.t[next_] - before;
    if (!(width <= longest_)) return std::nullopt;
    const double part = (t - before) / width;
    return (1.0 - part) * series_.v[next_ - 1] + part * series_.v[next_];
  }
  // Number of samples before the last time asked for.
  std::size_t passed() const { return next_; }

 private:
  const VectorSeries& series_;
  std::size_t next_ = 0;
  double longest_ = 0.0;
};

void add_truth(const MotionTruth& truth, ArraySamples& out) {
  std::size_t next = 0;
  for (const double t : out.t) {
    while (next + 1 < truth.t.size() && truth.t[next + 1] <= t) ++next;
    const bool has_next = next + 1 < truth.t.size();
    const double width = has_next ? truth.t[next + 1] - truth.t[next] : 0.0;
    const double part = has_next ? std::clamp((t - truth.t[next]) / width, 0.0, 1.0) : 0.0;
    const std::size_t after = part > 0.0 ? next + 1 : next;
    const Rot3& R = truth.nRb[next];
    out.true_p.push_back((1.0 - part) * truth.position[next] + part * truth.position[after]);
    out.true_nRb.push_back(R * Rot3::Exp(part * (R.inverse() * truth.nRb[after]).Log()));
    out.true_valid.push_back(truth.valid[next] && truth.valid[after] &&
                             std::abs(t - truth.t[next]) <= std::max(width, 1e-6));
  }
}

// The integral of a rate that each sample holds until the next, from the first sample on.
class HeldIntegral {
 public:
  explicit HeldIntegral(const VectorSeries& series) : series_(series) {
    interval_ = 1.0 / series.rate_hz();
  }
  double begin() const { return series_.t.front(); }
  double end() const { return series_.t.back() + interval_; }
  // Over [t0, t1], which lies in [begin, end]; t0 does not fall from call to call.
  Vector3 over(double t0, double t1) {
    while (at_ + 1 < series_.size() && series_.t[at_ + 1] <= t0) ++at_;
    Vector3 sum = Vector3::Zero();
    double from = t0;
    for (std::size_t i = at_; from < t1; ++i) {
      const double to = i + 1 < series_.size() ? std::min(t1, series_.t[i + 1]) : t1;
      sum += (to - from) * series_.v[i];
      from = to;
    }
    return sum;
  }
  // The sample nearest to t.
  Vector3 nearest(double t) const {
    const auto after = std::ranges::lower_bound(series_.t, t - 0.5 * interval_);
    const auto i = static_cast<std::size_t>(after - series_.t.begin());
    return series_.v[std::min(i, series_.size() - 1)];
  }

 private:
  const VectorSeries& series_;
  std::size_t at_ = 0;
  double interval_ = 0.0;
};

void check(const Recording& recording, const std::vector<Vector3>& positions) {
  const std::size_t count = recording.mag.size();
  if (positions.size() != count) {
    throw InputError(recording.name, 0, 0,
                     fmt::format("the layout has {} places, the recording {} magnetometers",
                                 positions.size(), count),
                     "give a layout with one place for each magnetometer, in their order");
  }
  if (count == 0 || recording.acc.size() < 2 || recording.gyr.size() < 2 ||
      std::ranges::any_of(recording.mag, [](const VectorSeries& s) { return s.size() < 2; })) {
    throw InputError(recording.name, 0, 0, "a sensor has fewer than two samples",
                     "navigation needs accelerometer, gyroscope and every magnetometer");
  }
}

// The magnetometers' readings at the times of `out`. A slow magnetometer's sample counts once, at
// the first time after it.
void add_readings(const Recording& recording, ArraySamples& out) {
  const std::size_t count = recording.mag.size();
  std::vector<Interpolator> mags(recording.mag.begin(), recording.mag.end());
  out.mag =
      MatrixXd::Zero(static_cast<Eigen::Index>(3 * count), static_cast<Eigen::Index>(out.t.size()));
  std::size_t used = 0;  // samples of the first magnetometer up to the last reading
  for (std::size_t k = 0; k < out.t.size(); ++k) {
    bool measured = true;
    for (std::size_t m = 0; m < count; ++m) {
      const std::optional<Vector3> reading = mags[m].at(out.t[k]);
      measured = measured && reading.has_value();
      out.mag.block<3, 1>(static_cast<Eigen::Index>(3 * m), static_cast<Eigen::Index>(k)) =
          reading.value_or(Vector3::Zero());
    }
    const VectorSeries& first = recording.mag.front();
    std::size_t seen = mags.front().passed();
    if (seen < first.size() && first.t[seen] == out.t[k]) ++seen;
    out.measured.push_back(measured && seen > used);
    if (measured) used = seen;
  }
}

}  // namespace

ArraySamples array_samples(const Recording& recording, const std::vector<Vector3>& positions,
                           StepReadings readings) {
  check(recording, positions);
  ArraySamples out;
  out.name = recording.name;
  out.positions = positions;
  const VectorSeries& acc = recording.acc;
  HeldIntegral gyr(recording.gyr);
  const double slack = 0.5 / recording.gyr.rate_hz();
  std::vector<Vector3> force;
  for (std::size_t k = 0; k < acc.size(); ++k) {
    if (acc.t[k] < gyr.begin() - slack || acc.t[k] > gyr.end()) continue;
    out.t.push_back(acc.t[k]);
    force.push_back(acc.v[k]);
  }
  if (out.t.size() < 2) {
    throw InputError(recording.name, 0, 0, "accelerometer and gyroscope have no times in common",
                     "look at the time column");
  }
  for (std::size_t k = 0; k + 1 < out.t.size(); ++k) {
    const double t0 = out.t[k], t1 = out.t[k + 1];
    if (readings == StepReadings::kHeld) {
      out.acc.push_back(force[k]);
      out.gyr.push_back(gyr.nearest(t0));
      continue;
    }
    // The force at the step's end, turned into the body's frame at its start.
    const Vector3 turn = gyr.over(t0, t1);
    out.acc.push_back(0.5 * (force[k] + Rot3::Exp(turn) * force[k + 1]));
    out.gyr.push_back(turn / (t1 - t0));
  }
  out.acc.push_back(out.acc.back());
  out.gyr.push_back(out.gyr.back());
  add_readings(recording, out);
  if (recording.truth && !recording.truth->position.empty()) add_truth(*recording.truth, out);
  return out;
}

}  // namespace magimu
