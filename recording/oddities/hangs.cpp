// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/hangs.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

// A run of equal readings that chance makes once in 1e6, of readings that each repeat with the
// probability that the sensor shows; and the jump at its end, in usual changes.
constexpr double kLogChanceOfRun = -13.8, kJumpAfterHanging = 5.0;
constexpr std::size_t kShortestRun = 4;

// Of readings that each repeat with the probability that this sensor shows.
bool longer_than_chance(const RepeatedReading& unit, const UsualReadings& usual) {
  if (unit.count < kShortestRun) return false;
  return double(unit.count - 1) * std::log(usual.repeats) < kLogChanceOfRun;
}

// Whether the reading after the first one lies much further from it than readings usually change.
bool resumes_elsewhere(const RepeatedReadings& units, const UsualReadings& usual,
                       const Vector3& usual_change) {
  const Vector3 jump = (units[1].v - units.front().v).cwiseAbs();
  for (int axis = 0; axis < 3; ++axis) {
    if (jump[axis] > std::max({kJumpAfterHanging * usual_change[axis],
                               kSomeJump * usual.noise[axis], kSomeSteps * usual.step[axis]})) {
      return true;
    }
  }
  return false;
}

// The run is longer than chance makes it where this sensor is as lively as before and after, and
// ends with a jump to where the sensor would have gone meanwhile.
bool hung(const ReadingsAround& readings, const UsualReadings& usual) {
  const RepeatedReadings &kept = readings.kept, &units = readings.waiting;
  const RepeatedReading& unit = units.front();
  if (!usual.lively || !longer_than_chance(unit, usual) || kept.size() < 3 || units.size() < 4) {
    return false;
  }
  Vector3 change = Vector3::Zero();
  std::size_t longest = 1;
  const auto look = [&](const RepeatedReading& a, const RepeatedReading& b) {
    change = change.cwiseMax((a.v - b.v).cwiseAbs());
  };
  for (std::size_t i = 1; i <= 3; ++i) {
    const RepeatedReading &before = kept[kept.size() - i], &after = units[i];
    longest = std::max({longest, before.count, after.count});
    look(before, i == 1 ? unit : kept[kept.size() - i + 1]);
    if (i > 1) look(after, units[i - 1]);
  }
  return unit.count >= kShortestRun * longest && resumes_elsewhere(units, usual, change);
}

// A sensor that never changes is dead, which the program says in words of its own.
bool never_changed(const ReadingsAround& readings) {
  return readings.kept.empty() && readings.waiting.size() == 1;
}

// The device turned meanwhile, and the sensor goes on elsewhere, or never.
bool turned_while_still(const ReadingsAround& readings, const UsualReadings& usual,
                        const OtherSensors& others) {
  const RepeatedReadings& units = readings.waiting;
  const RepeatedReading& unit = units.front();
  if (never_changed(readings) || !others.turned || !longer_than_chance(unit, usual)) return false;
  if (units.size() > 1 && !resumes_elsewhere(units, usual, Vector3::Zero())) return false;
  return others.turned(unit.begin_s, unit.end_s);
}

// The sensor's noise alone would have changed its readings, and other sensors' readings change.
bool frozen(const ReadingsAround& readings, const UsualReadings& usual,
            const OtherSensors& others) {
  const RepeatedReadings& units = readings.waiting;
  const RepeatedReading& unit = units.front();
  if (never_changed(readings) || !others.others_change || !longer_than_chance(unit, usual) ||
      double(unit.count - 1) * std::log(usual.same_noise) > kLogChanceOfRun) {
    return false;
  }
  std::size_t longest = 1;
  for (const RepeatedReading& before : readings.kept) longest = std::max(longest, before.count);
  for (std::size_t i = 1; i < units.size(); ++i) longest = std::max(longest, units[i].count);
  return unit.count >= kShortestRun * longest && others.others_change(unit.begin_s, unit.end_s);
}

}  // namespace

bool hangs(const ReadingsAround& readings, const UsualReadings& usual, const OtherSensors& others) {
  return hung(readings, usual) || turned_while_still(readings, usual, others) ||
         frozen(readings, usual, others);
}

}  // namespace magimu
