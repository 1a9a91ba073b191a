// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/recurring_jumps.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kMostJumps = 0.5;           // of the axis's jumps go to a value that means nothing
constexpr std::size_t kDifferentJumps = 64;  // remembered

}  // namespace

bool RecurringJumps::count(const Vector3& reading, const Neighbours& around,
                           const UsualReadings& usual, double times) {
  bool new_value = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double jump = std::abs(reading[axis] - around.middle[axis]);
    const double some = kSomeJump * usual.roughness[axis];
    if (!(jump > std::max(some, times * around.spread[axis]))) continue;
    auto& jumps = jumps_[std::size_t(axis)];
    const auto at = std::ranges::find(jumps, reading[axis], &Jump::value);
    if (at != jumps.end()) {
      ++at->count;
      new_value = false;
    } else if (jumps.size() < kDifferentJumps) {
      jumps.push_back({reading[axis], 1});
    }
  }
  return new_value;
}

Sentinels RecurringJumps::sentinels() const {
  Sentinels out = known_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t all = 0;
    for (const Jump& jump : jumps_[axis]) all += jump.count;
    for (const Jump& jump : jumps_[axis]) {
      if (jump.count >= kRecurs && double(jump.count) > kMostJumps * double(all)) {
        out[axis].push_back(jump.value);
      }
    }
  }
  return out;
}

std::optional<int> RecurringJumps::sentinel_axis(const Vector3& reading, const Vector3& kept,
                                                 const UsualReadings& usual) const {
  const Sentinels values = sentinels();
  for (int axis = 0; axis < 3; ++axis) {
    const auto& of_axis = values[std::size_t(axis)];
    if (std::ranges::find(of_axis, reading[axis]) == of_axis.end()) continue;
    if (std::abs(reading[axis] - kept[axis]) > kSomeJump * usual.roughness[axis]) return axis;
  }
  return std::nullopt;
}

}  // namespace magimu
