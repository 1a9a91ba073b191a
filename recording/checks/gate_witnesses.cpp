// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/gate_witnesses.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kTurningRate = 0.2;    // rad/s: the device turns
constexpr double kTurnedEnough = 0.15;  // rad: and has turned so far, which changes any reading
constexpr double kSlowly = 5.0;         // times slower than the fastest tenth
constexpr double kTurningShare = 0.3;   // of gravity or the field, by which they turn meanwhile

std::pair<std::size_t, std::size_t> span_within(const VectorSeries& s, double begin, double end) {
  const auto first = std::ranges::lower_bound(s.t, begin),
             last = std::ranges::upper_bound(s.t, end);
  return {std::size_t(first - s.t.begin()), std::size_t(std::max(first, last) - s.t.begin())};
}

std::vector<double> lengths_within(const VectorSeries& s, double begin, double end) {
  std::vector<double> out;
  const auto [first, last] = span_within(s, begin, end);
  for (std::size_t k = first; k < last; ++k) {
    if (s.v[k].allFinite()) out.push_back(s.v[k].norm());
  }
  return out;
}

double size_quantile(std::vector<double> x, double share) {
  if (x.empty()) return 0.0;
  const auto at = x.begin() + std::ptrdiff_t(share * double(x.size() - 1));
  std::ranges::nth_element(x, at);
  return *at;
}

bool changed(const VectorSeries& s, double begin, double end) {
  const auto [first, last] = span_within(s, begin, end);
  if (last <= first) return false;
  double squares = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> x;
    for (std::size_t k = first; k < last; ++k) {
      if (s.v[k].allFinite()) x.push_back(s.v[k][axis]);
    }
    const double range = size_quantile(x, 0.9) - size_quantile(x, 0.1);
    squares += range * range;
  }
  return std::sqrt(squares) > kTurningShare * size_quantile(lengths_within(s, begin, end), 0.5);
}

}  // namespace

GateWitnesses::GateWitnesses(const Recording& recording)
    : recording_(recording),
      usual_rate_(size_quantile(lengths_within(recording.gyr, -1e300, 1e300), 0.9)) {}

bool GateWitnesses::turned(SensorGate::Sensor hung, double begin, double end) const {
  const double rate = size_quantile(lengths_within(recording_.gyr, begin, end), 0.5);
  const double usual = usual_rate_ / kSlowly;  // its unit is not known for certain
  if (rate > std::max({kTurningRate, kTurnedEnough / (end - begin), usual})) return true;
  if (hung == SensorGate::Sensor::kMag || recording_.mag.empty()) return false;
  return changed(recording_.mag.front(), begin, end) &&
         (hung == SensorGate::Sensor::kAcc || changed(recording_.acc, begin, end));
}

bool GateWitnesses::others_change(SensorGate::Sensor hung, double begin, double end) const {
  const auto changes = [&](const VectorSeries& s) {
    const auto [first, last] = span_within(s, begin, end);
    std::size_t differ = 0;
    for (std::size_t k = first + 1; k < last; ++k) differ += s.v[k] != s.v[k - 1] ? 1 : 0;
    return last > first + 1 && 2 * differ > last - first;
  };
  return (hung != SensorGate::Sensor::kGyr && changes(recording_.gyr)) ||
         (hung != SensorGate::Sensor::kAcc && changes(recording_.acc)) ||
         (hung != SensorGate::Sensor::kMag && std::ranges::any_of(recording_.mag, changes));
}

}  // namespace magimu
