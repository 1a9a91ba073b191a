// SPDX-License-Identifier: BSD-3-Clause
// A board that is turned about all three of its axes from the first second on, with noise and hard
// iron: what a fault of units or axes needs to show itself within 5 s.
#pragma once

#include <cmath>
#include <random>

#include "recording/data/recording.h"

namespace magimu::test {

inline Recording turned_board(double seconds, unsigned seed = 1, double rate = 80.0) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> noise;
  const auto random = [&] {
    const double x = noise(bits), y = noise(bits), z = noise(bits);
    return Vector3(x, y, z);
  };
  const Vector3 phase = 3.0 * random();
  Recording r;
  r.name = "board.csv";
  r.mag.resize(1);
  r.mag_names = {"mag"};
  Rot3 nRb = Rot3::Exp(random());
  for (int k = 0; k < int(rate * seconds); ++k) {
    const double t = k / rate;
    const Vector3 omega(2.2 * std::sin(1.4 * t + phase[0]), 2.0 * std::cos(1.1 * t + phase[1]),
                        1.8 * std::sin(0.9 * t + phase[2]));
    r.acc.push_back(t, nRb.unrotate(Vector3(0, 0, 9.80665)) + 0.03 * random());
    r.gyr.push_back(t, omega + 0.002 * random());
    r.mag[0].push_back(t, nRb.unrotate(Vector3(0, 18, -45)) + Vector3(5, -3, 2) + 0.2 * random());
    nRb = (nRb * Rot3::Exp(omega / rate)).normalized();
  }
  return r;
}

}  // namespace magimu::test
