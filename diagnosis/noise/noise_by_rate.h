// SPDX-License-Identifier: BSD-3-Clause
// Are a sensor's residuals larger where the sensor turns faster? Noise has the same size at all
// rates. An error that changes from sample to sample (of the times, of lost or repeated samples)
// grows with the rate, and has no mean that a dependence on the rate could find.
#pragma once

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu {

struct NoiseByRate {
  double statistic = 0.0;  // chi-square with 1 degree of freedom under Gaussian noise of one size
  double log10_p = 0.0;    // of growth with the rate, by the scatter of blocks of 2 s: right for
                           // coloured and heavy-tailed noise, too
  double fast_over_slow = 1.0;  // RMS of the fastest third over that of the slowest
};

// series: of one sensor of this recording, node by node.
NoiseByRate noise_by_rate(const ResidualSeries& series, const Recording& recording);

}  // namespace magimu
