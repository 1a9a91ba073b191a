// SPDX-License-Identifier: BSD-3-Clause
// Random numbers that are the same everywhere: a seed names a data set, so what it draws may not
// depend on the standard library (std::normal_distribution does). The engine std::mt19937_64 is
// fixed by the C++ standard bit by bit; the distributions here are our own. Every purpose has a
// stream of its own, so that asking for another rate, more noise or a second magnetometer leaves
// all other draws as they were.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "graph/scalar.h"

namespace magimu {

// What a stream is for. The numbers are part of what a seed means: append, never renumber.
enum class RandomPurpose : std::uint64_t {
  kImuParameters = 1,
  kMagnetometerParameters = 2,  // one stream a magnetometer
  kMotion = 3,
  kAccelerometerNoise = 4,
  kGyroscopeNoise = 5,
  kMagnetometerNoise = 6,  // one stream a magnetometer
  kPace = 7,
  kDisplacement = 8,
  kEffectSize = 9,    // one stream a name
  kEffectNoise = 10,  // one stream a sensor
  kBiasDrift = 11,
  kRoom = 12,         // dipoles of a room
  kArrayStart = 13,   // where a filter is told that it starts
  kGroupsOfTen = 14,  // data sets of a study
  kHandRoom = 15,     // a room about a sensor held by hand
  kTravel = 16,       // path of whoever carries the sensor
};

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, RandomPurpose purpose, std::uint64_t index = 0)
      : engine_(mix(mix(mix(seed) + static_cast<std::uint64_t>(purpose)) + index)) {}

  // Uniform on [0, 1): the upper 53 bits.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double uniform(double from, double to) { return from + (to - from) * uniform(); }
  // A seed for what has random numbers of its own.
  std::uint64_t bits() { return engine_(); }
  // One of 0 .. n - 1.
  int index(int n) { return static_cast<int>(uniform() * n); }

  // Standard normal, by Box and Muller: two uniforms make two independent normals.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));  // 1 - u is never 0
    const double angle = 2.0 * kPi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

  // Component by component: the order of evaluation of a constructor's arguments is unspecified.
  Vector3 uniform3(double from, double to) {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = uniform(from, to);
    return v;
  }
  Vector3 normal3() {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = normal();
    return v;
  }

  static constexpr double kPi = 3.14159265358979323846;

 private:
  // SplitMix64's finalizer: neighbouring seeds and purposes start the engine far apart.
  static constexpr std::uint64_t mix(std::uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
  }

  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace magimu
