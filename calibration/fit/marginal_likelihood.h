// SPDX-License-Identifier: BSD-3-Clause
// How probable a model makes the readings, whatever trajectory and parameters there were: the
// measure by which noise densities are compared that decide how the trajectory may move, and
// that therefore leave residuals of the same size.
#pragma once

#include "calibration/fit/stage.h"

namespace magimu {

// log p(y | noise, reach), up to a constant that depends on the factors alone: Laplace's integral
// over the trajectory and all parameters, at the optimum of the stage. Exact where the model is
// linear,
//
//   -1/2 |r|^2 - 1/2 log det(J' J) + sum of log det of the factors' whitening matrices,
//
// r and J whitened. Nats.
double log_marginal_likelihood(const Stage& stage);

// log det of the matrix that whitens one factor's residual; 0 where it has none. A sum of the logs
// of densities is no substitute: velocity and position over an interval have the noise of both the
// accelerometer and the gyroscope.
double log_det_whitening(const FactorBatch& batch, int i);

}  // namespace magimu
