// SPDX-License-Identifier: BSD-3-Clause
// Where a sensor gets to whose bearer walks, drives or flies: a smooth random velocity in n, at
// rest where the turning rests (hand_motion.h), and the way that it leads. In a stretch of length
// L,
//
//   v(t) = sum_k c_k (cos k s - cos (k + 2) s),     s = pi (t - start) / L
//
// whose terms and their derivatives are 0 at both ends; the shortest has a period of about 8 s.
// Heights change by a tenth of the rest.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/motions/spline.h"

namespace magimu {

class TravelledPath {
 public:
  // A stretch of travel for each of the motion's stretches. rms_mps: root mean square of |v| while
  // it moves.
  TravelledPath(std::uint64_t seed, const std::vector<Spline>& stretches, double rms_mps);

  // In n, from where it began: m, m/s, m/s^2.
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
