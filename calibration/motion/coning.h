// SPDX-License-Identifier: BSD-3-Clause
// What a gyroscope's sample says of a turn. Most gyroscopes give the mean of their rate over an
// interval h. Where the axis turns meanwhile, that is not the constant rate that leads from the
// attitude at its beginning to the one at its end (coning; Bortz 1971, to second order):
//
//   w_constant = w + h^2 / 12 w x w'
//
// with w' the rate's derivative. Others, and simulations, give the latter.
#pragma once

#include "recording/data/recording.h"

namespace magimu {

// Means of the rate as constant rates. Samples at the ends and beside gaps stay as they are.
VectorSeries constant_rates(const VectorSeries& means);

// The squares of what that changes, in those of white noise of this density, rad/s per sqrt(Hz).
double squares_of_coning(const VectorSeries& means, double density);

}  // namespace magimu
