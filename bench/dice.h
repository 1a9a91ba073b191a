// SPDX-License-Identifier: BSD-3-Clause
// Draws of the studies that damage recordings: the same from a seed everywhere (the engine is fixed
// by the C++ standard bit by bit, its distributions are not; these are our own).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

namespace magimu {

class Dice {
 public:
  // Every purpose of a seed has draws of its own.
  Dice(std::uint64_t seed, std::string_view purpose) {
    std::uint64_t mixed = 1469598103934665603u;  // FNV-1a
    for (const char letter : purpose) mixed = (mixed ^ std::uint64_t(letter)) * 1099511628211u;
    engine_.seed(mixed ^ (seed * 0x9E3779B97F4A7C15u));
  }

  double uniform(double from = 0.0, double to = 1.0) {
    return from + (to - from) * double(engine_() >> 11) * 0x1p-53;
  }
  double log_uniform(double from, double to) {
    return std::exp(uniform(std::log(from), std::log(to)));
  }
  std::size_t index(std::size_t n) { return std::size_t(uniform() * double(n)); }
  bool chance(double p) { return uniform() < p; }
  double sign() { return chance(0.5) ? -1.0 : 1.0; }
  // Box and Muller, the second of the pair thrown away.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  template <class T>
  const T& pick(const std::vector<T>& from) {
    return from[index(from.size())];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace magimu
