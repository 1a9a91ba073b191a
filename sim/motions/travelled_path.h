// SPDX-License-Identifier: BSD-3-Clause
// The path of a sensor whose bearer walks, rides or flies: a smooth random velocity in n, and the
// position that it leads to. The path rests where the turning rests (hand_motion.h). In a stretch
// of L seconds
//
//   v(t) = sum_k c_k (cos k s - cos (k + 2) s),     s = pi (t - start) / L
//
// The terms and their derivatives are 0 at both ends. Periods are longer than 8 s (L, in a stretch
// shorter than that). The vertical velocity is a tenth of that along a horizontal axis.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/motions/spline.h"

namespace magimu {

class TravelledPath {
 public:
  // stretches: of the motion; each has a leg of travel. rms_mps: root mean square of |v|, m/s, over
  // all legs.
  TravelledPath(std::uint64_t seed, const std::vector<Spline>& stretches, double rms_mps);

  // In n: m from where the path began, m/s, m/s^2.
  Vector3 position(double t) const { return at(t, 0); }
  Vector3 velocity(double t) const { return at(t, 1); }
  Vector3 acceleration(double t) const { return at(t, 2); }

 private:
  struct Leg {
    double start, end;
    std::vector<Vector3> coefficient;  // c_k
    Vector3 from = Vector3::Zero();
    Vector3 at(double t, int derivative) const;
  };
  Vector3 at(double t, int derivative) const;
  std::vector<Leg> legs_;
};

}  // namespace magimu
