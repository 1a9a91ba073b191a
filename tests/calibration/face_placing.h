// SPDX-License-Identifier: BSD-3-Clause
// A sensor that is laid on one face after another: lifted, turned by a quarter about an axis of its
// own, and put down again, with a rest after each. Hardly an attitude is taken more than twice, and
// any moment is near the end of a rest.
#pragma once

#include <cmath>
#include <cstdint>

#include "factors/sensor_model.h"
#include "graph/rot3.h"
#include "recording/data/recording.h"
#include "sim/draws/random.h"

namespace magimu::test {

struct FacePlacing {
  double rate_hz = 50.0, turn_s = 1.1, rest_s = 1.4, lift_m = 0.08;
  int turns = 24;
  NoiseDensities noise{2e-3, 2e-4, 0.03};
  Vector3 acc_bias{0.1, -0.05, 0.08}, gyr_bias{0.004, -0.006, 0.002}, mag_bias{12.0, -20.0, 7.0};
  double dip_rad = 55.0 * kDegree, strength_uT = 48.0;
  // From its half on.
  Vector3 gyr_step = Vector3::Zero(), mag_step = Vector3::Zero();

  double half_s() const { return 0.5 * turns * (turn_s + rest_s); }
};

inline Recording recording_of(const FacePlacing& o, std::uint64_t seed) {
  RandomStream motion(seed, RandomPurpose::kMotion), noise(seed, RandomPurpose::kGyroscopeNoise);
  const double dt = 1.0 / o.rate_hz, root = std::sqrt(o.rate_hz);
  const Vector3 g(0.0, 0.0, -9.80665);
  const Vector3 field(0.0, o.strength_uT * std::cos(o.dip_rad),
                      -o.strength_uT * std::sin(o.dip_rad));
  Matrix3 D;
  D << 1.02, 0.01, -0.02, 0.0, 0.97, 0.01, 0.015, -0.01, 1.01;
  Recording r;
  r.name = "faces";
  r.mag_names = {"mag"};
  r.mag.resize(1);
  Rot3 before;
  double t = 0.0;
  for (int turn = 0; turn < o.turns; ++turn) {
    // A hand is not exact. Twice the same axis is one turn more seldom than two.
    const Vector3 draw = motion.normal3();
    Vector3 axis = Vector3::Unit((turn + int(draw.x() > 0.5)) % 3) + 0.05 * motion.normal3();
    const double angle = 0.5 * M_PI * (draw.y() > 0.0 ? 1.0 : -1.0) + 0.05 * draw.z();
    axis.normalize();
    const auto angle_at = [&](double s) {
      const double x = std::clamp(s / o.turn_s, 0.0, 1.0);
      return angle * (x - std::sin(2.0 * M_PI * x) / (2.0 * M_PI));
    };
    const int samples = int(std::lround((o.turn_s + o.rest_s) * o.rate_hz));
    for (int k = 0; k < samples; ++k, t += dt) {
      const double s = k * dt, x = s / o.turn_s, w = M_PI / o.turn_s;
      const Rot3 nRb = before * Rot3::Exp(angle_at(s) * axis);
      // Height: the lift times sin(w s)^4.
      const double sin2 = std::pow(std::sin(w * s), 2);
      const double rise = o.lift_m * w * w * (12.0 * sin2 - 16.0 * sin2 * sin2);
      const Vector3 a(0.0, 0.0, x < 1.0 ? rise : 0.0);
      const bool after = t >= o.half_s();
      r.acc.push_back(
          t, nRb.unrotate(Vector3(a - g)) + o.acc_bias + o.noise.acc * root * noise.normal3());
      r.gyr.push_back(t, (angle_at(s + dt) - angle_at(s)) / dt * axis + o.gyr_bias +
                             (after ? o.gyr_step : Vector3::Zero()) +
                             o.noise.gyr * root * noise.normal3());
      r.mag.front().push_back(t, D * nRb.unrotate(field) + o.mag_bias +
                                     (after ? o.mag_step : Vector3::Zero()) +
                                     o.noise.mag * root * noise.normal3());
    }
    before = before * Rot3::Exp(angle_at(2.0 * o.turn_s) * axis);
  }
  return r;
}

}  // namespace magimu::test
