// SPDX-License-Identifier: BSD-3-Clause
// A motion that follows an estimated one: cubic B-splines of rate and position through the nodes of
// a trajectory, with knots as far apart as the estimate's noise allows, so that the simulated hand
// does not shake by what was noise. At rest in the trajectory's rests.
#pragma once

#include <utility>
#include <vector>

#include "graph/rot3.h"
#include "sim/motions/spline.h"

namespace magimu {

struct EstimatedTrajectory {
  std::vector<double> t;                         // s, increasing, the first not before 0
  std::vector<Rot3> nRb;                         // at these times
  std::vector<Vector3> v, p;                     // in n, m/s and m; empty: the sensor only turned
  std::vector<std::pair<double, double>> rests;  // s, in order
  // What the rate and acceleration from one node to the next hold of noise: densities of gyroscope
  // and accelerometer.
  double rate_density = 0.0, acceleration_density = 0.0;
};

class FollowedMotion {
 public:
  // trajectory: four nodes or more.
  FollowedMotion(const EstimatedTrajectory& trajectory, double duration_s);

  const Rot3& initial_nRb() const { return initial_nRb_; }
  Vector3 omega(double t) const { return rate(t, 0); }       // body frame, rad/s
  Vector3 omega_rate(double t) const { return rate(t, 1); }  // its derivative

  bool moves() const { return !path_.coefficient.empty(); }
  // In n; derivative 0, 1 or 2.
  Vector3 position(double t, int derivative = 0) const { return path_.at(t, derivative); }

 private:
  Vector3 rate(double t, int derivative) const;

  std::vector<Spline> turns_;  // between the rests
  Spline path_;
  Rot3 initial_nRb_;
};

}  // namespace magimu
