// SPDX-License-Identifier: BSD-3-Clause
// A simulated device for tests of the gate.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "recording/data/recording.h"

namespace magimu::test {

// A device that turns about slowly changing axes for 60 s at 100 Hz and rests for 5 s before.
inline Recording turning(unsigned seed = 1) {
  constexpr double kRate = 100.0, kRest = 5.0;
  std::mt19937 bits(seed);
  std::normal_distribution<double> noise;
  const auto random = [&] { return Vector3(noise(bits), noise(bits), noise(bits)); };
  Recording r;
  r.name = "turning.csv";
  r.mag.resize(1);
  r.mag_names = {"mag"};
  Rot3 nRb;
  for (int k = 0; k < 6500; ++k) {
    const double t = k / kRate, s = std::max(0.0, t - kRest), on = std::min(1.0, s);
    const Vector3 omega =
        on * Vector3(1.5 * std::sin(0.7 * s), 1.2 * std::cos(0.5 * s), std::sin(0.3 * s + 1.0));
    r.acc.push_back(t, nRb.unrotate(Vector3(0, 0, 9.81)) + 0.03 * random());
    r.gyr.push_back(t, omega + 0.005 * random());
    r.mag[0].push_back(t, nRb.unrotate(Vector3(0, 18, -45)) + Vector3(5, -3, 2) + 0.3 * random());
    nRb = (nRb * Rot3::Exp(omega / kRate)).normalized();
  }
  return r;
}

inline VectorSeries& series_of(Recording& r, const std::string& sensor) {
  return sensor == "acc" ? r.acc : sensor == "gyr" ? r.gyr : r.mag[0];
}

// As a converter with this step does.
inline void round_to(VectorSeries& s, double step) {
  for (Vector3& v : s.v) v = (v / step).array().round() * step;
}

}  // namespace magimu::test
