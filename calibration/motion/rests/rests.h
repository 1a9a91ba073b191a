// SPDX-License-Identifier: BSD-3-Clause
// Phases in which the sensor lies still, found by the angular rate energy detector (Skog et al.
// 2010) less slow turns (turned_rests.h), and what they tell: gyroscope bias, the sensors' noise.
#pragma once

#include <optional>

#include "factors/sensor_model.h"
#include "recording/data/recording.h"

namespace magimu {

struct RestOptions {
  double window_s = 0.5;         // the detector averages over this long
  double max_rate_rad_s = 0.03;  // RMS deviation of the rate from its own mean within a rest
  double max_bias_rad_s = 0.2;   // a steady turn faster than any plausible bias is no rest
  double min_length_s = 1.0;     // shorter phases, less one window at each end, are not used
};

struct TimeSpan {
  double begin_s = 0.0, end_s = 0.0;
  double length_s() const { return end_s - begin_s; }
};

std::vector<TimeSpan> find_rests(const Recording& recording, const RestOptions& options = {});

inline constexpr double kExcessNoise = 1.3;  // of the accelerometer, over what it is compared with

// Those that show the inertial sensors' own noise: without those in which the accelerometer is
// clearly noisier (kExcessNoise) than any part is, and not by white noise. It lay in a hand, which
// trembles, or on something that shook.
std::vector<TimeSpan> quiet_rests(const Recording& recording, std::vector<TimeSpan> rests);

// Mean of the gyroscope over the rests; nothing if there are none.
std::optional<Vector3> gyr_bias_at_rest(const Recording& recording,
                                        const std::vector<TimeSpan>& rests);

// Densities from the scatter about each rest's own mean; a density is 0 where the rests have too
// few samples of that sensor. Those of accelerometer and gyroscope are of quiet rests.
NoiseDensities noise_at_rest(const Recording& recording, const std::vector<TimeSpan>& rests);

// The magnetometers', one each.
std::vector<double> mag_noise_at_rest(const Recording& recording,
                                      const std::vector<TimeSpan>& rests);

// The largest density that the accelerometer's noise may have, m/s^2/sqrt(Hz): that of the noisiest
// parts, and its rounding. Beyond it, something moves.
double noisiest_acc(const VectorSeries& acc);

// Density of an inertial sensor's noise where it never rests, at the least: from sixth differences
// of its samples, which a hand moves too smoothly to show in; the lower quartile of pieces of half
// a second. A filter in the sensor, or samples that come twice, make it smaller than it is. 0: too
// few.
double least_noise(const VectorSeries& series);

}  // namespace magimu
