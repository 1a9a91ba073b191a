// SPDX-License-Identifier: BSD-3-Clause
// The sequence of turns that Huang et al. 2025 recommend (section Summary and Practical Issues):
// half a turn in yaw, pitch and roll, then on and on so as to cover the sphere. Every turn is about
// an axis of the body (x, y, z, or a diagonal between two of them) at a mean pace of 1 rad/s with a
// soft start and end,
//
//   omega(t) = axis * pace * (1 - cos(2 pi x)),  x the part of the turn that has passed,
//
// and half a second of rest after it. From the fourth turn on the next axis is the one whose half
// turn passes furthest from where gravity and north have been in the body's frame. A hand is not
// exact: each turn departs from its axis by some 3 deg and from its angle by some 3 %.
#pragma once

#include <cstdint>
#include <vector>

#include "graph/rot3.h"

namespace magimu {

class TurnSequence {
 public:
  // rest_s: the rest at the start, part of duration_s; the sequence goes on until the end.
  TurnSequence(std::uint64_t seed, double duration_s, double rest_s);

  // Level, its x axis about north, as the paper's filters assume: within a few degrees.
  const Rot3& initial_nRb() const { return initial_nRb_; }
  Vector3 omega(double t) const { return at(t, false); }      // body frame, rad/s
  Vector3 omega_rate(double t) const { return at(t, true); }  // its derivative, rad/s^2

  static constexpr double kDuration = 63.0;  // s, unless asked otherwise
  static constexpr double kRest = 3.0;       // s, at the start unless asked otherwise

 private:
  struct Turn {
    double start = 0.0, length = 0.0;     // s
    Vector3 mean_rate = Vector3::Zero();  // rad/s
  };
  Vector3 at(double t, bool derivative) const;

  Rot3 initial_nRb_;
  std::vector<Turn> turns_;
};

}  // namespace magimu
