// SPDX-License-Identifier: BSD-3-Clause
// What pictures show of a channel's residuals: their correlation over time and their spectrum, mean
// of the three axes. Samples count as evenly spaced; what is not a number counts as zero.
#pragma once

#include <vector>

#include "graph/rot3.h"

namespace magimu::apps {

struct Curve {
  std::vector<double> x, y;
};

// Median interval between samples, s; 0 with fewer than two.
double median_interval(const std::vector<double>& t);

// x: lag, s, from one sample on; y: correlation, 1 at lag zero.
Curve autocorrelation(const std::vector<Vector3>& residuals, double interval_s, int lags);

// Power over frequency, Hz: a Hann-windowed periodogram, averaged within so many equal steps of
// log frequency per decade. White residuals of variance 1 have 1 throughout.
Curve spectrum(const std::vector<Vector3>& residuals, double interval_s, int per_decade = 12);

// For drawing: of each of so many stretches of time its least and its greatest value, in their
// order; a gap, or time that runs backward (the next recording), is a NaN.
Curve envelope(const std::vector<double>& t, const std::vector<double>& y, int stretches);

}  // namespace magimu::apps
