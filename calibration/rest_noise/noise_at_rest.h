// SPDX-License-Identifier: BSD-3-Clause
// The noise of every sensor in a recording of a device that lies still: allan.h for each axis, and
// a file of the format "magimu-noise/1" (docs/formats.md) whose densities `calibrate --noise`
// takes.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calibration/motion/rests/rests.h"
#include "calibration/rest_noise/allan.h"
#include "recording/data/recording.h"

namespace magimu {

struct SensorNoise {
  std::string name, unit;  // "acc", "gyr", "mag", ...; "m/s^2"
  double interval_s = 0.0;
  std::size_t samples = 0;
  std::array<AxisNoise, 3> axes;

  double white() const;  // root mean square of the axes, per sqrt(Hz)
};

struct RestNoise {
  std::string recording;
  TimeSpan span;                     // that was used
  std::vector<SensorNoise> sensors;  // acc, gyr, magnetometers
  std::vector<std::string> notes;

  NoiseDensities densities() const;  // white, of the first magnetometer
};

// Where the device moves, and so no answer: in words, with times and what to do. Empty: it lies.
struct MotionAtRest {
  std::string reason;
  TimeSpan rest;  // the longest rest
};
MotionAtRest motion_at_rest(const Recording& recording);

// Of the longest rest, which motion_at_rest found to be long enough.
RestNoise noise_of(const Recording& recording, const TimeSpan& rest);

nlohmann::ordered_json to_json(const RestNoise& noise);
// The densities of such a file. InputError.
NoiseDensities read_noise(const std::string& path);

}  // namespace magimu
