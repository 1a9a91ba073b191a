// SPDX-License-Identifier: BSD-3-Clause
// Reasons not to name an effect although it fits: real recordings have causes that come and go, and
// with enough samples everything is significant.
#pragma once

#include <array>

#include "diagnosis/search/option.h"

namespace magimu {

// Do the halves of the recordings contradict each other about the effect? The distance between the
// estimates of the two, as a share of the effect itself, both in the metric of its information:
// an effect that one half lacks gives 1, one that changes its sign 4; 0 where noise makes them
// differ as much in one of a thousand recordings.
double contradiction_of_halves(const Stage& stage, std::size_t effect);

// Is the step of a bias change, the effect that entered last, sharper than the slow changes beside
// it? The jump of the mean residual over some seconds across it, over the root mean square of such
// jumps at all other times; infinite where those are no more than white noise.
double sharpness(const Option& option, const Stage& stage);

// Noise on the scale of a second where the sensor rests, from second differences of means over 0.75
// s (the Hadamard deviation, to which a steady drift is no noise), as the density of white noise
// that would scatter these means as much. Coloured noise has more of it than single samples show.
struct SlowNoise {
  double acc = 0.0, gyr = 0.0;  // m/s^2, rad/s per sqrt(Hz); 0: no rest is long enough
  double freedom = 0.0;         // degrees of freedom of their squares

  // By how much its variance exceeds that of white noise of the density, beyond chance; else 1.
  double excess(Sensor channel, const NoiseDensities& white) const;
};
SlowNoise slow_noise_at_rest(const std::vector<const Recording*>& recordings);

// By how much the variance of single samples exceeds that of the given noise; 1 where it is less
// than a tenth. Outliers, or noise that is larger than a data sheet says, make whatever is tested
// look larger. One a channel: acc, gyr, mag.
std::array<double, 3> excess_of_samples(const std::vector<const Recording*>& recordings,
                                        const Stage& stage, const NoiseDensities& given);

// A bias that wanders does so where the sensor rests, too, and from one rest to the next: the
// changes of its means, over pieces of 1 to 16 s, have the variance q^2 (D - T / 3), T the length
// of the pieces and D the time between their middles; noise only adds to it. density: q, rad/s per
// sqrt(s). True where they are too small even for a walk of half that density.
bool rests_contradict_walk(const std::vector<const Recording*>& recordings, double density);

}  // namespace magimu
