// SPDX-License-Identifier: BSD-3-Clause
// Random numbers of the oracle, its own from the engine up: a seed and a stream name a sequence
// that is the same everywhere, and what one stream draws leaves the others as they were.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace magimu::oracle {

// What a stream is for. The numbers are part of what a seed means: append, never renumber.
enum class Stream : std::uint64_t {
  kDevice = 1,
  kMotion,
  kNoise,       // + channel
  kOutliers,    // + channel
  kRepetition,  // + channel
  kBiasDrift,
  kTapping,
  kTimeJitter,
  kEffectSize,
  kRoom,
};

// xorshift64* (Vigna 2016) started from a mixed seed.
class Random {
 public:
  Random(std::uint64_t seed, Stream stream, std::uint64_t index = 0)
      : state_(mix(mix(seed ^ 0xA5A5A5A55A5A5A5Au) + 1000u * static_cast<std::uint64_t>(stream) +
                   index) |
               1u) {
    for (int i = 0; i < 8; ++i) next();
  }

  // Uniform on (0, 1).
  double uniform() { return (static_cast<double>(next() >> 11) + 0.5) * 0x1p-53; }
  double uniform(double from, double to) { return from + (to - from) * uniform(); }
  int index(int n) { return static_cast<int>(uniform() * n); }
  double sign() { return uniform() < 0.5 ? -1.0 : 1.0; }
  // Of either sign, its size uniform between the two.
  double signed_size(double least, double most) {
    const double s = sign();
    return s * uniform(least, most);
  }

  // Standard normal by Marsaglia's polar method.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double x = 0.0, y = 0.0, r2 = 2.0;
    while (r2 >= 1.0) {
      x = uniform(-1.0, 1.0);
      y = uniform(-1.0, 1.0);
      r2 = x * x + y * y;
    }
    const double scale = std::sqrt(-2.0 * std::log(r2) / r2);
    spare_ = scale * y;
    has_spare_ = true;
    return scale * x;
  }
  Eigen::Vector3d normal3() {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = normal();
    return v;
  }
  Eigen::Vector3d uniform3(double from, double to) {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = uniform(from, to);
    return v;
  }
  Eigen::Vector3d direction() { return normal3().normalized(); }

 private:
  std::uint64_t next() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return state_ * 0x2545F4914F6CDD1Du;
  }
  // MurmurHash3's 64-bit finalizer.
  static constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 33)) * 0xFF51AFD7ED558CCDu;
    x = (x ^ (x >> 33)) * 0xC4CEB9FE1A85EC53u;
    return x ^ (x >> 33);
  }

  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace magimu::oracle
