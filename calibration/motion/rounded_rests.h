// SPDX-License-Identifier: BSD-3-Clause
// While a sensor rests, a coarse converter gives the same reading again and again. Its rounding
// error is one for the whole rest, not one a sample. A fit that counts every sample as a
// measurement believes this one error a thousand times. So nodes between which the sensor turns by
// less than a quarter of a step count together, as the number of readings that are independent of
// each other.
#pragma once

#include <vector>

#include "calibration/motion/nodes.h"

namespace magimu {

// What rounding to multiples of `step` makes of a resting sensor with white noise of standard
// deviation sigma: its mean is wrong by a constant, whose variance over all places between two
// levels is (the mean of a rounded normal variable as a Fourier series of its place)
//   sum over m of (step / (pi m))^2 / 2 exp(-(2 pi m sigma / step)^2)
// and its single readings by sigma^2 + step^2 / 12 in all.
double rounded_mean_variance(double step, double sigma);
// The sigma whose rounded readings scatter by `scatter` (standard deviation) about their own mean.
double sigma_before_rounding(double step, double scatter);
// Of so many samples of a rest: as many independent ones would determine the mean as well.
double independent_readings(double step, double sigma, double samples);

// Per magnetometer and node of a plan: the share of its samples that are independent readings; 0:
// it is left out, since another node of the same rest has said the same. Empty: 1 everywhere.
std::vector<std::vector<double>> independent_shares(const Recording& recording,
                                                    const std::vector<double>& nodes);

}  // namespace magimu
