// SPDX-License-Identifier: BSD-3-Clause
// What a person does who turns a board in the hands to calibrate it: hold it still, turn it about
// one axis after the other with short rests in between, hold it still again. The rate is a closed
// form in continuous time, so one seed is one motion, whatever the sampling rate:
//
//   omega(t) = sum_j c_j B((t - t_j) / h)
//
// in every stretch of movement, B the cubic B-spline and h about 0.4 s, and exactly 0 in the rests.
// The spline makes it smooth (two continuous derivatives, also where a rest begins), limits its
// band (hardly anything above 1.5 Hz) and its speed: |omega| <= max |c_j|.
// The coefficients are turns of 2 to 4 s about the axes x, y, z, each somewhat tilted and with a
// little wobble. Every six turns hold both signs of every axis, in random order, so the opening six
// have turned the sensor both ways about all its axes within 20 s.
#pragma once

#include <cstdint>
#include <vector>

#include "graph/rot3.h"
#include "sim/motions/spline.h"

namespace magimu {

class HandMotion {
 public:
  // rest_s: the rest at the start, part of duration_s. The rest at the end takes 3 s, or a quarter
  // of what remains if that is less; between them rest 2 to 3 s for every 40 to 60 s.
  // varied_pace: the whole motion is slower or faster, by a factor drawn from 0.3 to 1.2.
  HandMotion(std::uint64_t seed, double duration_s, double rest_s, bool varied_pace = false);

  // Within 10 deg of level, with any heading.
  const Rot3& initial_nRb() const { return initial_nRb_; }
  // Body frame, rad/s, at most kFastest (1.2 times that at a varied pace).
  Vector3 omega(double t) const { return at(t, 0); }
  Vector3 omega_rate(double t) const { return at(t, 1); }  // its derivative, rad/s^2

  // Stretches of movement, of the rate in rad/s; outside of all of them the sensor rests.
  const std::vector<Spline>& stretches() const { return stretches_; }

  static constexpr double kDuration = 120.0;  // s, unless asked otherwise
  static constexpr double kRest = 3.0;        // s, at the start unless asked otherwise; at the end
  static constexpr double kFastest = 2.5;     // rad/s

 private:
  Vector3 at(double t, int derivative) const;

  Rot3 initial_nRb_;
  std::vector<Spline> stretches_;
};

}  // namespace magimu
