// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/array_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "recording/error.h"

namespace magimu {
namespace {

// Samples further apart than so many of their usual intervals are not interpolated.
constexpr double kLongestInterval = 2.5;

// Walks along a series as the times asked for rise.
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
  // The samples before the time last asked for.
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

}  // namespace

ArraySamples array_samples(const Recording& recording, const std::vector<Vector3>& positions) {
  const std::size_t count = recording.mag.size();
  if (positions.size() != count) {
    throw InputError(recording.name, 0, 0,
                     fmt::format("the layout has {} places, the recording {} magnetometers",
                                 positions.size(), count),
                     "give a layout with one place for each magnetometer, in their order");
  }
  if (recording.acc.size() < 2 || recording.gyr.size() < 2 ||
      std::ranges::any_of(recording.mag, [](const VectorSeries& s) { return s.size() < 2; })) {
    throw InputError(recording.name, 0, 0, "a sensor has fewer than two samples",
                     "navigation needs accelerometer, gyroscope and every magnetometer");
  }
  ArraySamples out;
  out.name = recording.name;
  out.positions = positions;
  Interpolator acc(recording.acc);
  std::vector<Interpolator> mags(recording.mag.begin(), recording.mag.end());
  out.mag = MatrixXd::Zero(static_cast<Eigen::Index>(3 * count),
                           static_cast<Eigen::Index>(recording.gyr.size()));
  for (std::size_t k = 0; k < recording.gyr.size(); ++k) {
    const double t = recording.gyr.t[k];
    const std::optional<Vector3> force = acc.at(t);
    if (!force) continue;  // the step to the next sample is then the longer
    const auto column = static_cast<Eigen::Index>(out.t.size());
    // A slow magnetometer's sample counts once.
    const std::size_t passed = mags.front().passed();
    bool measured = true;
    for (std::size_t m = 0; m < count; ++m) {
      const std::optional<Vector3> reading = mags[m].at(t);
      measured = measured && reading.has_value();
      out.mag.block<3, 1>(static_cast<Eigen::Index>(3 * m), column) =
          reading.value_or(Vector3::Zero());
    }
    const VectorSeries& first = recording.mag.front();
    const bool is_new =
        mags.front().passed() != passed || out.t.empty() ||
        (mags.front().passed() < first.size() && first.t[mags.front().passed()] == t);
    out.t.push_back(t);
    out.acc.push_back(*force);
    out.gyr.push_back(recording.gyr.v[k]);
    out.measured.push_back(measured && is_new);
  }
  if (out.t.size() < 2) {
    throw InputError(recording.name, 0, 0, "accelerometer and gyroscope have no times in common",
                     "look at the time column");
  }
  out.mag.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(out.t.size()));
  if (recording.truth && !recording.truth->position.empty()) add_truth(*recording.truth, out);
  return out;
}

}  // namespace magimu
