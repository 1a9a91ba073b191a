// SPDX-License-Identifier: BSD-3-Clause
// What white noise of a sensor leaves under a fit: residuals that are not white.
//
// Fitted attitudes follow the samples' noise, slow noise more than fast: at the nodes the
// residuals' covariance is I - H, H = J P J' with P the posterior covariance. The mean spectrum of
// H is estimated with seeded random vectors (Hutchinson) and fitted by the form that it has for a
// random walk observed in white noise. Between two nodes a sample's attitude lies on the line from
// one to the other, up to the gyroscope's noise. Of a direction's three components the two across
// it depend on the attitude.
#pragma once

#include "calibration/fit/stage.h"
#include "calibration/motion/sensor_rows.h"

namespace magimu {

struct FitSpectrum {
  double share = 0.0;   // of H at frequency 0, mean of the components
  double corner = 1.0;  // sine of half the phase a node at which it is half of that
  double nodes_per_s = 1.0;
  // Square of the gyroscope's density, as it moves readings across their direction, over the square
  // of the sensor's own density, 1/s^2.
  double walk = 0.0;
  // Of an accelerometer beside the point of turning: the variance of omega' x r by the gyroscope's
  // noise is that of the sensor's own times this, s^2, times the square of a slope's response.
  double arm = 0.0;
  double rate_hz = 1.0;  // of the gyroscope, whose samples the slope is of

  // Of H, at the nodes.
  double followed(double hz) const;
  // Power of the samples' residuals over that of the white noise.
  double power(double hz) const;
};

// index: of the recording; gyr_hz: rate of its gyroscope. With too few nodes: share = 0, as of a
// sensor that no fit follows.
FitSpectrum fit_spectrum(const Stage& stage, Sensor sensor, int index, double gyr_hz);

}  // namespace magimu
