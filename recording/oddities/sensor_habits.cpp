// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/sensor_habits.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace magimu {
namespace {

// A reading less its neighbours' mean, where all three have the noise sigma: its variance is 1.5
// sigma^2. Quantiles of the absolute value of a standard normal number: 1.645 for 0.9, 0.6745 for
// 0.5.
constexpr double kBendOfNoise = 1.2247448713915890, kNineTenths = 1.645, kHalf = 0.6745;
// A value by which a driver says that it has none bends three of the readings about it, so that one
// in thirty of them is in a tenth of all bends. Three quarters of all suffer one in twelve; motion
// makes the others larger by so much at most.
constexpr double kThreeQuarters = 1.1503, kMostMotion = 4.0;
// Two normal numbers of one standard deviation differ by less than half of a small step with the
// density 1 / (2 sqrt(pi)); the tenth of all that is next to 0 is below 0.1257.
constexpr double kSameStep = 0.28209479177387814, kOneTenth = 0.1257;
constexpr double kRounding = 1e-12;  // of the value: no step of a converter
constexpr double kLivelySteps = 2.0;
constexpr double kStepsToLimit =
    20.0;  // from the mean to a limit: nearer, it is the usual value of a coarse sensor
constexpr double kNoiseToLimit = 10.0;  // likewise, in standard deviations
constexpr double kSameRange = 1.5;      // steps

}  // namespace

void SizeHistogram::add(double x) {
  ++count_;
  x = std::abs(x);
  if (!(x > 0.0)) {
    ++zeros_;
    return;
  }
  // The exponent tells the octave, the mantissa its quarter. A logarithm of every reading took
  // longer than all else here.
  const double quarters[] = {1.1892071150027210, 1.4142135623730951, 1.6817928305074290};
  const std::uint64_t of_mantissa = (std::uint64_t(1) << 52) - 1;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const double mantissa =
      std::bit_cast<double>((bits & of_mantissa) | std::bit_cast<std::uint64_t>(1.0));
  int bin = kBinsPerOctave * (int(bits >> 52) - 1023 - kFirstOctave);
  for (const double quarter : quarters) bin += mantissa >= quarter ? 1 : 0;
  ++bins_[std::size_t(std::clamp(bin, 0, int(bins_.size()) - 1))];
}

double SizeHistogram::quantile(double share) const {
  if (count_ == 0) return 0.0;
  std::size_t seen = zeros_;
  const double wanted = share * double(count_);
  if (double(seen) >= wanted) return 0.0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    seen += bins_[bin];
    if (double(seen) >= wanted) {
      return std::exp2(double(bin + 1) / kBinsPerOctave + kFirstOctave);
    }
  }
  return std::exp2(double(kOctaves + kFirstOctave));
}

void SensorHabits::add(double t, const Vector3& v) {
  lengths_.add(v.norm());
  sum_ += v;
  extreme_ = extreme_.cwiseMax(v.cwiseAbs());
  for (int axis = 0; axis < 3; ++axis) {
    const bool moved = others_moved(axis, v);
    ends_[std::size_t(2 * axis)].add(t, v[axis], moved);
    ends_[std::size_t(2 * axis + 1)].add(t, -v[axis], moved);
  }
  if (known_before_ > 0 && v == before_[1]) {
    long_runs_ += in_run_ ? 0 : 1;
    in_run_ = true;
    return;
  }
  ++runs_;
  in_run_ = false;
  if (known_before_ > 0) {
    for (int axis = 0; axis < 3; ++axis) {
      const double change = std::abs(v[axis] - before_[1][axis]);
      const bool real = change > kRounding * extreme_[axis];
      if (real && (step_[axis] == 0.0 || change < step_[axis])) step_[axis] = change;
      if (known_before_ > 1) {
        bends_[std::size_t(axis)].add(before_[1][axis] - 0.5 * (before_[0][axis] + v[axis]));
      }
    }
  }
  before_[0] = before_[1];
  before_[1] = v;
  known_before_ = std::min(known_before_ + 1, 2);
}

// Whether the other axes changed by more than a converter's noise at rest.
bool SensorHabits::others_moved(int axis, const Vector3& v) const {
  constexpr double kMovedSteps = 5.0;
  if (known_before_ == 0) return false;
  for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
    const double change = std::abs(v[other] - before_[1][other]);
    if (step_[other] > 0.0 && change > kMovedSteps * step_[other]) return true;
  }
  return false;
}

double SensorHabits::roughness(int axis) const {
  const SizeHistogram& bends = bends_[std::size_t(axis)];
  const double most = bends.quantile(0.9) / kNineTenths;
  const double usual = bends.quantile(0.75) / kThreeQuarters;
  return std::max(std::min(most, kMostMotion * usual) / kBendOfNoise, 0.5 * step_[axis]);
}

double SensorHabits::noise(int axis) const {
  const double bend = bends_[std::size_t(axis)].quantile(0.5);
  return std::max(bend / (kBendOfNoise * kHalf), 0.5 * step_[axis]);
}

bool SensorHabits::lively(int axis) const { return noise(axis) > kLivelySteps * step_[axis]; }

double SensorHabits::repeats() const { return (double(long_runs_) + 0.5) / (double(runs_) + 1.0); }

double SensorHabits::same_noise() const {
  double chance = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double quiet = bends_[std::size_t(axis)].quantile(0.1) / (kBendOfNoise * kOneTenth);
    if (quiet > kSameStep * step_[axis]) chance *= kSameStep * step_[axis] / quiet;
  }
  return chance;
}

bool SensorHabits::clipped(int axis, int sign) const {
  if (!settled() || !far_from_mean(axis, sign)) return false;
  if (clipped_by_itself(axis, sign)) return true;
  // All axes have one range; its two ends may differ by one count (two's complement).
  if (!end(axis, sign).has_run()) return false;
  for (int i = 0; i < 6; ++i) {
    const int other = i / 2, way = i % 2 == 0 ? 1 : -1;
    const double apart = std::abs(end(axis, sign).top().x - end(other, way).top().x);
    const bool same = apart <= kSameRange * std::max(step_[axis], step_[other]);
    if (same && far_from_mean(other, way) && clipped_by_itself(other, way)) return true;
  }
  return false;
}

bool SensorHabits::far_from_mean(int axis, int sign) const {
  const double mean = sum_[axis] / double(lengths_.count());
  return std::abs(limit(axis, sign) - mean) >
         std::max(kStepsToLimit * step_[axis], kNoiseToLimit * noise(axis));
}

bool SensorHabits::clipped_by_itself(int axis, int sign) const {
  // With noise of a step and more the same step comes again in 0.4 of samples, with more noise less
  // often: no run of many at the end of what is read is chance.
  constexpr double kSameAtMost = 0.4, kExpectedRuns = 1e-6;
  const ExtremeValues& values = end(axis, sign);
  const double same = std::min(kSameAtMost, kSameStep * step_[axis] / noise(axis));
  const auto no_chance = [&](std::size_t run) {
    return noise(axis) > step_[axis] &&
           double(lengths_.count()) * std::pow(same, run) < kExpectedRuns;
  };
  // One run is enough if the other axes change meanwhile.
  return values.looks_clipped(no_chance(values.top().longest_run) || lively(axis)) ||
         (values.piles_up() && no_chance(values.top().longest_held));
}

}  // namespace magimu
