// SPDX-License-Identifier: BSD-3-Clause
// The part of readings that is faster than a hand: each reading less the quadratic fitted to it and
// its four neighbours on each side (Savitzky and Golay 1964, nine points, second order). A
// trajectory that follows a sensor's samples absorbs the slow part of their noise. This filter
// removes that part, too, whatever the trajectory.
//
//   y = x - c * x,   c_0..4 = (59, 54, 39, 14, -21) / 231,   c_-l = c_l
//
// Of white noise of variance 1 it leaves the variance 1 - c_0 = 172/231 = 0.745 and the
// autocovariance r_l = delta_l - 2 c_l + sum_j c_j c_j+l, in parts of r_0: -0.349, -0.267, -0.072,
// 0.258, -0.030, -0.036, -0.015, 0.011. At least half the power passes from 0.17 of the sampling
// rate upwards. A polynomial of the third degree is removed entirely.
#pragma once

#include <array>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

inline constexpr int kHighPassReach = 4;                         // samples to each side
inline constexpr double kHighPassVariance = 1.0 - 59.0 / 231.0;  // share left of white noise's

// c_l; 0 beyond the reach.
double smoothing_weight(int lag);

// Squared gain at the frequency omega, radians a sample.
double high_pass_gain(double omega);

// In the sensor's unit. The quadratic goes through nine samples at their times, also beside
// gaps; at the ends through the first or the last nine. Fewer than nine samples give zeros.
std::vector<Vector3> high_passed(const VectorSeries& series);
// The same of evenly spaced values.
std::vector<Vector3> high_passed(const std::vector<Vector3>& values);

}  // namespace magimu
