// SPDX-License-Identifier: BSD-3-Clause
// What parts' tolerances may have done to a calibration without being seen. The model may take
// gains and axes of accelerometer and gyroscope as exact. Where the sensor stays about level (a
// boat, a car, a figure of eight), a gain of the accelerometer looks like its bias: no residual
// shows it, and the bias is wrong by 0.1 m/s^2 with a sigma of 0.003.
//
// In each direction that the motion shows or hides by itself, an error is either not there or as
// large as parts usually have it: the eigenvectors of L A L, A the information of a family of
// errors with motion and calibration eliminated (Scan), L its prior standard deviations
// (Effect::prior_sigma). An error that is there is no tiny one: its density, in units of L, is
// 3 x^2 times that of N(0, 1/3), with variance 1 (a non-local prior, Johnson and Rossell 2010), so
// that what data show to be zero has next to no probability already where they show it to some
// percent of L. With the information lambda and the score y of a direction in units of L / sqrt(3),
// v = 1 / (1 + lambda) and m = y v,
//
//   p(data | there) / p(data | not there) = sqrt(v) (m^2 + v) exp(y m / 2)
//
// and, where it is there, its density is x^2 times that of N(m, v). How many of all n
// directions have an error is as probable for each number from 0 to n (Scott and Berger 2010): of a
// device that is exact where the motion shows it, the rest is less likely to be wrong. Where the
// data show nothing at all, each direction has one half.
//
// The errors' second moment, times what they do to the calibration, widens its covariance: after a
// rich motion by next to nothing.
#pragma once

#include <vector>

#include "factors/effects/effect.h"

namespace magimu {

// Families of errors that every part has within its tolerances, beside the gyroscope's matrix.
inline constexpr const char* kErrorsOfParts[] = {"acc_scale_misalignment", "gyro_g_sensitivity"};
// Is it one of them, or that matrix?
bool is_tolerance(const Effect& effect);

// Directions of a family: the logarithm of the odds of an error at even odds beforehand, and its
// mean and variance where it is there; axes: what one of each is in the family's parameters.
struct ToleranceDirections {
  VectorXd log_odds, mean, variance;
  MatrixXd axes;
};

// A: information of the family's parameters, z: their score, excess: the variance of the noise over
// what the information takes it to be; sigma: of usual parts.
ToleranceDirections tolerance_directions(const MatrixXd& A, const VectorXd& z, double excess,
                                         const VectorXd& sigma);

// E[x x'] of each family's parameters x.
std::vector<MatrixXd> unseen_tolerances(const std::vector<ToleranceDirections>& families);

}  // namespace magimu
