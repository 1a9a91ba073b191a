// SPDX-License-Identifier: BSD-3-Clause
// What parts' tolerances may have done to a calibration without being seen. The model takes gains
// and axes of accelerometer and gyroscope as exact. Where the sensor stays about level (a boat, a
// car, a figure of eight), a gain of the accelerometer looks like its bias: no residual shows it,
// and the bias is wrong by 0.1 m/s^2 with a sigma of 0.003.
//
// In each direction that the motion shows or hides by itself, an error is either not there or as
// large as parts usually have it: the eigenvectors of L A L, A the information of a family of
// errors with motion and calibration eliminated (Scan), L its prior standard deviations
// (Effect::prior_sigma). With the information lambda and the score y of such a direction, in units
// of L,
//
//   log(p(data | there) / p(data | not there)) = y^2 / (2 (1 + lambda)) - log(1 + lambda) / 2
//
// and, where it is there, its size is N(y / (1 + lambda), 1 / (1 + lambda)). How many of a family's
// n directions have an error is as probable for each number from 0 to n (Scott and Berger 2010): of
// a sensor that is exact where the motion shows it, the rest is less likely to be wrong. What the
// data show to be zero has next to no probability (Occam's factor); where they show nothing of the
// family, each direction has one half.
//
// The second moment of the family's errors, times what they do to the calibration, widens its
// covariance: after a rich motion by next to nothing.
#pragma once

#include "factors/effects/effect.h"

namespace magimu {

// Is it a family of errors that every part has within its tolerances?
bool is_tolerance(const Effect& effect);

// E[x x'] of the family's parameters x. A: their information, z: their score, excess: the variance
// of the noise over what the information takes it to be; sigma: of usual parts.
MatrixXd unseen_tolerances(const MatrixXd& A, const VectorXd& z, double excess,
                           const VectorXd& sigma);

}  // namespace magimu
