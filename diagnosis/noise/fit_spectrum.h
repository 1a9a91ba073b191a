// SPDX-License-Identifier: BSD-3-Clause
// What white noise of a sensor leaves under a fit: residuals that are not white.
//
// Attitudes bend towards the samples, the more the slower these are wrong: at the nodes the
// residuals' covariance is I - H, H = J P J' with P the posterior covariance. The mean spectrum of
// H is estimated with seeded random vectors (Hutchinson), and told by the form that it has for a
// random walk seen in white noise. Between two nodes a sample has the attitude on the line from one
// to the other, and the gyroscope's noise about that. Of a direction's three components the two
// across it show attitudes.
#pragma once

#include "calibration/fit/stage.h"
#include "calibration/motion/sensor_rows.h"

namespace magimu {

struct FitSpectrum {
  double share = 0.0;   // of H at frequency 0, mean of the components
  double corner = 1.0;  // sine of half the angle a node at which it is half of that
  double nodes_per_s = 1.0;
  // Of the gyroscope's noise: by how much it moves readings across their direction, over the
  // sensor's own density, squared, 1/s^2.
  double walk = 0.0;

  // Of H, at the nodes.
  double followed(double hz) const;
  // Power of the samples' residuals over that of the white noise.
  double power(double hz) const;
};

// index: of the recording. That of a sensor that no fit follows where there are too few nodes.
FitSpectrum fit_spectrum(const Stage& stage, Sensor sensor, int index);

}  // namespace magimu
