// SPDX-License-Identifier: BSD-3-Clause
// The noise of one axis at rest, sampled evenly: its overlapping Allan deviation, and the densities
// behind it. In the units of the series, tau in s:
//
//   adev^2(tau) = N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3
//
// N: white noise, per sqrt(Hz); B: bias instability (flicker), the flat floor; K: random walk of
// the bias, per s sqrt(Hz) (a walk's variance grows by K^2 a second). N, B and K are fitted to the
// spectrum of the differences of block means (Whittle's maximum likelihood), which also says how
// sure they are; the deviation is for the eye and checks them.
#pragma once

#include <vector>

namespace magimu {

// Of an axis; low and high: 95 % confidence.
struct AllanPoint {
  double tau_s = 0.0, deviation = 0.0, low = 0.0, high = 0.0;
};

// values: one a sample. per_decade: points a decade of tau; tau goes up to a third of the length.
std::vector<AllanPoint> allan_deviation(const std::vector<double>& values, double interval_s,
                                        int per_decade = 10);

// A value with its 95 % confidence; determined: it is above zero beyond chance (else high is a
// bound).
struct Bounded {
  double value = 0.0, low = 0.0, high = 0.0;
  bool determined = false;
};

struct AxisNoise {
  Bounded white, bias_instability, random_walk;
  double sample_density =
      0.0;  // of the samples as they are: differs from white if they are coloured
  // Lowest point of the Allan deviation, and whether it was still falling at the longest tau.
  AllanPoint lowest;
  bool still_falling = false;
  std::vector<AllanPoint> points;
};

struct NoiseFitOptions {
  // Samples are averaged over blocks of about so long, s: what a filter in the sensor or a repeated
  // sample does to neighbours then does not count as noise.
  double block_s = 0.05;
};

// Needs a hundred blocks at least; with fewer everything is zero.
AxisNoise fit_noise(const std::vector<double>& values, double interval_s,
                    const NoiseFitOptions& options = {});

// The closed form above.
double model_deviation(const AxisNoise& noise, double tau_s);

}  // namespace magimu
