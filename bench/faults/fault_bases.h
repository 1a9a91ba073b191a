// SPDX-License-Identifier: BSD-3-Clause
// Undamaged recordings for the sweep of faults: simulated by sim/ and by the tests' oracle, whose
// truth is known, and pieces of real ones where the data folder has them. Motion, rates, length,
// noise and the digits of the numbers are random, all from a seed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bench/faults/fault_log.h"
#include "factors/sensor_model.h"
#include "tests/oracle/sensors.h"

namespace magimu {

struct Base {
  std::uint64_t seed = 1;
  std::string source;  // "sim", "oracle" or the real file's name
  std::string motion;  // "paper", "hand", "hand_held", "rotation", "real"
  double rate_hz = 0.0;
  double duration_s = 0.0;
  // Turned about all axes for long enough that a calibration should be trusted.
  bool rich = false;
  Log log;
  std::optional<SensorParameters> truth;  // simulated ones
  oracle::Densities noise{};              // of the simulated ones, per sqrt(Hz)

  int magnetometers() const { return log.sensors() - 2; }
};

struct BaseWishes {
  bool real = true;           // a piece of a real recording will do
  bool small = false;         // for tests: at most about 4000 samples
  std::string data_dir = "";  // of real recordings; empty: none
};

Base draw_base(std::uint64_t seed, const BaseWishes& wishes);

// The same device with the same noise and rates in another, poorer motion. Simulated bases only.
Log with_motion(const Base& base, oracle::MotionKind motion);

}  // namespace magimu
