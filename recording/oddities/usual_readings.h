// SPDX-License-Identifier: BSD-3-Clause
// What the gate for a sensor's samples (sensor_gate.h) compares a reading with: the sensor's habits
// (sensor_habits.h) as they were when last looked up. Internal to the gate.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>

#include "recording/oddities/sensor_habits.h"

namespace magimu {

// One reading, and how often the sensor repeated it without a change.
struct RepeatedReading {
  Vector3 v;              // in the sensor's unit
  double begin_s, end_s;  // times of the first and of the last sample
  std::size_t count;      // samples
};

using RepeatedReadings = std::deque<RepeatedReading>;

// The first readings that are not judged yet, and the last ones before them that were kept.
struct ReadingsAround {
  const RepeatedReadings& kept;
  const RepeatedReadings& waiting;
};

struct UsualReadings {
  std::size_t samples = 0;  // of which the habits were looked up
  bool settled = false, lively = false;
  Vector3 roughness, noise, extreme, step;      // as in SensorHabits, in the sensor's unit
  double length = 0.0, largest = 0.0;           // of a reading
  double repeats = 0.0, same_noise = 0.0;       // probabilities, as in SensorHabits
  std::array<std::optional<double>, 6> limits;  // of x, y, z, upper and lower

  // All but `samples`. The largest reading is taken to be at least so long.
  void look_up(const SensorHabits& habits, double largest_at_least);
  const std::optional<double>& limit(int axis, int sign) const {
    const int place = 2 * axis + (sign > 0 ? 0 : 1);
    return limits[std::size_t(place)];
  }
};

// A jump that is looked at at all, in standard deviations of the noise.
inline constexpr double kSomeJump = 10.0;
// Steps of the converter. A reading that stood still has hung if the next one is farther away than
// this; a slow change goes on by a step or two.
inline constexpr double kSomeSteps = 5.0;
// Readings on either side that one is compared with.
inline constexpr std::size_t kSide = 4;

}  // namespace magimu
