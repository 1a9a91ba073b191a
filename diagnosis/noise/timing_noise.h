// SPDX-License-Identifier: BSD-3-Clause
// Are a sensor's samples of other times than they say, each by an amount of its own? Then part of
// what is left of them lies along the change of the reading, d_k = d reading / dt,
//
//   e_k = tau_k d_k,   tau_k of mean 0 and variance j^2,
//
// more where it changes fast. What counts is the mean of their squares,
//
//   E[e_k e_k'] = S + a (d d' + c c') / |d|^2 + b (d d' + c c') + g |d|^2 I + j^2 d d',
//
// fitted by least squares: noise of any size and colour has some S, errors of the attitude lie in
// the plane of d and of c, the change that the same turn about the axis across would make, and
// either may grow with the rate. j alone knows the direction of d.
//
// tau may come in a pattern: a sensor that measures every 10 ms and is read every 7 is up to 10 ms
// old, again in the same way every 70 ms.
#pragma once

#include "diagnosis/noise/noise_tests.h"

namespace magimu {

struct TimingNoise {
  double jitter_s = 0.0;  // j
  double added = 0.0;     // mean variance that it adds to an axis, in parts of the variance seen
  double log10_p = 0.0;   // by the scatter of blocks of 2 s
  double period_s = 0.0;  // of the pattern; 0: none is seen
};

// Of residuals with a `change`. Only what is faster than a hand counts: slow errors of the model
// lie along the motion, too.
TimingNoise timing_noise(const SampleResiduals& samples);

}  // namespace magimu
