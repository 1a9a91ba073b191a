// SPDX-License-Identifier: BSD-3-Clause
// What the readings of one sensor usually are: how rough, how large, how often the same twice, in
// which steps, and where its range ends. Learnt sample by sample in bounded memory, without a unit,
// and from quantiles, so that a few impossible readings among many do not count.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "recording/data/extreme_values.h"
#include "recording/data/recording.h"

namespace magimu {

// How often numbers of which size came, in bins of a quarter octave.
class SizeHistogram {
 public:
  void add(double x);
  std::size_t count() const { return count_; }
  // A number that this share of all does not exceed, accurate to 20 %.
  double quantile(double share) const;

 private:
  static constexpr int kBinsPerOctave = 4, kOctaves = 160, kFirstOctave = -80;
  std::array<std::uint32_t, kBinsPerOctave * kOctaves> bins_{};
  std::size_t count_ = 0, zeros_ = 0;
};

class SensorHabits {
 public:
  // A sample, later than the one before.
  void add(double t, const Vector3& v);
  std::size_t samples() const { return lengths_.count(); }
  // Whether there are enough samples to speak of habits.
  bool settled() const { return lengths_.count() >= kSettled; }

  // Standard deviation of a reading about the mean of its two neighbours (repeated readings count
  // once): including motion, from the 90 % quantile; and of noise alone, from the median.
  double roughness(int axis) const;
  double noise(int axis) const;
  // The smallest change of an axis; and whether noise moves the axis by several of these, so that
  // readings change even at rest.
  double step(int axis) const { return step_[axis]; }
  bool lively(int axis) const;
  // Length that this share of all readings does not exceed; for half of them, and for nearly all.
  double length(double share) const { return lengths_.quantile(share); }
  double usual_length() const { return length(0.5); }
  double largest_length() const {
    return lengths_.quantile(std::min(0.999, 1.0 - kFewOdd / double(lengths_.count() + 1)));
  }
  // Largest absolute value of an axis.
  double extreme(int axis) const { return extreme_[axis]; }
  // Share of readings that repeat once or more, in all axes. A run of repeats counts once, so that
  // a sensor that hangs for a long time does not count much.
  double repeats() const;
  // Probability of a repeat at rest: that the rounding of a noise as small as the quietest tenth
  // shows gives the same reading.
  double same_noise() const;

  // The value at which an axis is clipped, at its upper end (sign 1) or the lower one (-1).
  bool clipped(int axis, int sign) const;
  double limit(int axis, int sign) const { return double(sign) * end(axis, sign).top().x; }
  const ExtremeValues& end(int axis, int sign) const {
    const int place = 2 * axis + (sign > 0 ? 0 : 1);
    return ends_[std::size_t(place)];
  }

 private:
  bool others_moved(int axis, const Vector3& v) const;
  bool far_from_mean(int axis, int sign) const;
  bool clipped_by_itself(int axis, int sign) const;

  static constexpr std::size_t kSettled = 50;
  static constexpr double kFewOdd = 2.5;  // impossible readings, among few samples

  SizeHistogram lengths_;
  std::array<SizeHistogram, 3> bends_;
  std::array<ExtremeValues, 6> ends_;
  Vector3 sum_ = Vector3::Zero(), extreme_ = Vector3::Zero(), step_ = Vector3::Zero();
  std::array<Vector3, 2> before_;  // the last two readings that differ
  int known_before_ = 0;
  std::size_t runs_ = 0, long_runs_ = 0;  // of equal readings
  bool in_run_ = false;
};

}  // namespace magimu
