// SPDX-License-Identifier: BSD-3-Clause
// Jolts that an accelerometer does not sample faithfully: it reads them a little early or late, or
// folds down what is faster than half its rate. Either way a sample errs by about as much as the
// specific force changes from one sample to the next, times how far off in time it is. At rest that
// is hardly anything; on a knock it is far more than the noise.
#pragma once

#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// Noise density, m/s^2 per sqrt(Hz), over each interval of times (s; entry i: from i - 1 to i) for
// a sensor whose density at rest is `density`, and whose samples are off in time by `jitter`
// sampling intervals (a standard deviation):
//
//   density_i^2 = density^2 + jitter^2 h mean(|a_k - a_k-1|^2 / 3 - 2 density^2 / h)
//
// h: the sampling interval. The mean is over the samples there, never negative.
std::vector<double> acc_densities(const VectorSeries& acc, const std::vector<double>& times,
                                  double density, double jitter);

}  // namespace magimu
