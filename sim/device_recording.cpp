// SPDX-License-Identifier: BSD-3-Clause
#include "sim/device_recording.h"

#include <Eigen/LU>
#include <cmath>

#include "sim/draws/random.h"

namespace magimu {
namespace {

void add_own_noise(VectorSeries& series, double sigma, RandomStream random) {
  for (Vector3& v : series.v) v += sigma * random.normal3();
}

}  // namespace

Simulation simulate_device(const SimulationOptions& options, const SensorParameters& parameters) {
  SimulationOptions exact = options;
  exact.noise_factor = 0.0;
  exact.magnetometers = int(parameters.mag.size());
  exact.effects.clear();
  Simulation out = simulate(exact);
  Recording& r = out.recording;
  const SensorParameters& drawn = out.truth.parameters;
  // Exact readings of one device are exact readings of another, mapped.
  for (Vector3& v : r.acc.v) v += parameters.acc_bias - drawn.acc_bias;
  for (Vector3& v : r.gyr.v) v += parameters.gyr_bias - drawn.gyr_bias;
  const double rate = options.rate_hz, mag_rate = rate / options.mag_ratio;
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    const Matrix3 map = parameters.mag[m].distortion * drawn.mag[m].distortion.inverse();
    for (Vector3& v : r.mag[m].v) v = map * (v - drawn.mag[m].bias) + parameters.mag[m].bias;
    add_own_noise(r.mag[m], options.noise_factor * options.noise.mag * std::sqrt(mag_rate),
                  {options.seed, RandomPurpose::kMagnetometerNoise, m});
  }
  add_own_noise(r.acc, options.noise_factor * options.noise.acc * std::sqrt(rate),
                {options.seed, RandomPurpose::kAccelerometerNoise, 0});
  add_own_noise(r.gyr, options.noise_factor * options.noise.gyr * std::sqrt(rate),
                {options.seed, RandomPurpose::kGyroscopeNoise, 0});
  const double dip = drawn.dip_rad;
  out.truth.parameters = parameters;
  out.truth.parameters.dip_rad = dip;
  out.truth.noise = {options.noise_factor * options.noise.acc,
                     options.noise_factor * options.noise.gyr,
                     options.noise_factor * options.noise.mag};
  out.truth.strength_uT = field_strength_uT(parameters.mag.front().distortion);
  return out;
}

}  // namespace magimu
