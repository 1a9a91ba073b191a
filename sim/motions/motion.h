// SPDX-License-Identifier: BSD-3-Clause
// How a simulated sensor turns, as its gyroscope sees it: one mean rate for every sampling
// interval. The mean rate over [t_k, t_k+1) is the constant rate that leads from one attitude to
// the next,
//
//   R_k+1 = R_k Exp(mean_rate_k dt),   mean_rate_k = Log(R_k' R_k+1) / dt,
//
// so the discrete dynamic model of the paper holds exactly, whatever the motion does in between.
// Here: the paper's motion, and the way from a rate in continuous time to mean rates.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "graph/rot3.h"

namespace magimu {

struct AngularMotion {
  Rot3 initial_nRb;                // attitude at the first sample
  std::vector<Vector3> mean_rate;  // body frame, rad/s; one a sample, sample k at k / rate_hz
};

// The attitudes at the sample times, as many as there are mean rates (the last rate leads beyond).
std::vector<Rot3> integrate(const AngularMotion& motion, double rate_hz);

// Seconds the paper's motion takes: one nominal turn about each of its six axes, about 322 s.
double paper_motion_duration_s();

// Huang et al. 2025, section Simulation Study, as the paper's code does it: from the identity, six
// axes (x, y, z, xy, xz, yz) one after the other, nominally 0.1 rad/s about each axis named, for
// one nominal turn, 2 pi / |rate| seconds. In every step each component of the rate departs from
// the nominal one by 0.05 rad/s times a standard normal, whatever the step's length, so one seed is
// another motion at another rate. A longer duration starts over with the first axis. The first
// rest_s seconds (part of duration_s) are at rest.
AngularMotion paper_motion(std::uint64_t seed, double rate_hz, double duration_s, double rest_s);

// Samples the motion with the body rate omega(t), rad/s, in continuous time, from t = 0: the
// kinematics R' = R [omega] in steps of at most 1 ms with the fourth-order Magnus method, whose
// error at a hand's speed stays below rounding. Where omega is exactly 0 the mean rate is too.
AngularMotion sample_motion(const Rot3& initial_nRb, const std::function<Vector3(double)>& omega,
                            double rate_hz, double duration_s);

// The turn R(t0)' R(t1), t1 not before t0, by the same method.
Rot3 turn_between(const std::function<Vector3(double)>& omega, double t0, double t1);

// Samples in a recording of that length: at 0, 1 / rate_hz, ...
std::size_t sample_count(double duration_s, double rate_hz);

}  // namespace magimu
