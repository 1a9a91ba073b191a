// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/wrapped_readings.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

// Usual steps from one reading to the next that either side of the jump is from the end of the
// range, and that the jump is longer than.
constexpr double kStepsToEnd = 6.0, kWrapToStep = 10.0;

// A stream sees the jump before what follows; a reading that is back at once was a blow.
bool goes_on_from_there(const RepeatedReadings& units, int axis, double most) {
  if (units.size() <= kSide) return false;
  for (std::size_t i = 1; i <= kSide; ++i) {
    if (std::abs(units[i].v[axis] - units[i - 1].v[axis]) > most) return false;
  }
  return true;
}

}  // namespace

void WrappedReadings::turn_over(const RepeatedReadings& waiting, const UsualReadings& usual,
                                bool whole_file) {
  const RepeatedReading& unit = waiting.front();
  for (int axis = 0; axis < 3; ++axis) {
    double step = usual.roughness[axis];
    for (std::size_t i = 1; i < path_.size(); ++i) {
      step = std::max(step, std::abs(path_[i][axis] - path_[i - 1][axis]));
    }
    const double a = last_[axis], b = unit.v[axis], range = usual.extreme[axis];
    const double nearer = std::min(std::abs(a), std::abs(b));
    const double farther = std::max(std::abs(a), std::abs(b));
    int& turns = turns_over_[std::size_t(axis)];
    const bool wraps = a * b < 0.0 && std::abs(b - a) > kWrapToStep * step &&
                       nearer > range - kStepsToEnd * step &&
                       farther < range + kStepsToEnd * step &&
                       (whole_file || goes_on_from_there(waiting, axis, kStepsToEnd * step));
    // What came was garbage.
    const bool back =
        turns != 0 && a * b < 0.0 && (b < a) == (turns < 0) && std::abs(b - a) > range;
    if (wraps || back) turns += b < a ? 1 : -1;
  }
}

std::optional<int> WrappedReadings::wrapped_axis(const RepeatedReadings& waiting,
                                                 const UsualReadings& usual,
                                                 std::optional<double> waits_s) {
  const RepeatedReading& unit = waiting.front();
  // Across a gap a reading may go from any end of the range to the other.
  if (path_.size() == kSide) {
    const double interval = (path_s_.back() - path_s_.front()) / double(kSide - 1);
    if (unit.begin_s - path_s_.back() > double(kSide) * interval) {
      path_.clear();
      path_s_.clear();
    }
  }
  if (path_.size() == kSide) turn_over(waiting, usual, !waits_s);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    turns_seen_[axis][turns_over_[axis]] += unit.count;
  }
  // A stream cannot look back: what lasts longer than it may wait is where the sensor is.
  const bool any = std::ranges::any_of(turns_over_, [](int turns) { return turns != 0; });
  if (!any) {
    right_s_ = unit.end_s;
  } else if (waits_s && unit.end_s - right_s_ > *waits_s) {
    turns_over_ = {0, 0, 0};
    path_.clear();
    path_s_.clear();
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (turns_over_[std::size_t(axis)] != 0) return axis;
  }
  return std::nullopt;
}

std::array<int, 3> WrappedReadings::usual_turns() const {
  std::array<int, 3> out = {0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto most =
        std::ranges::max_element(turns_seen_[axis], {}, [](const auto& x) { return x.second; });
    if (most != turns_seen_[axis].end()) out[axis] = most->first;
  }
  return out;
}

void WrappedReadings::follow(const RepeatedReading& unit, const UsualReadings& usual) {
  last_ = unit.v;
  Vector3 whole = unit.v;
  for (int axis = 0; axis < 3; ++axis) {
    whole[axis] += 2.0 * usual.extreme[axis] * turns_over_[std::size_t(axis)];
  }
  path_.push_back(whole);
  path_s_.push_back(unit.begin_s);
  if (path_.size() <= kSide) return;
  path_.pop_front();
  path_s_.pop_front();
}

}  // namespace magimu
