// SPDX-License-Identifier: BSD-3-Clause
// The effects that change a sensor's noise rather than its reading, each defined once: the
// simulation applies them to exact readings, the diagnosis to what its model predicts. They come in
// this order: mains, noise, quantization, clipping.
//
//   NoiseShape shape;
//   shape.correlation = 0.8;
//   add_noise(samples, sigma, shape, seed);
//   quantize(samples, 0.15);
#pragma once

#include <cstdint>
#include <vector>

#include "graph/rot3.h"

namespace magimu {

// What the noise of one channel is like; by default white and Gaussian.
struct NoiseShape {
  double scale = 1.0;        // noise_scale: sigma -> scale sigma
  double correlation = 0.0;  // correlated_noise: AR(1), between neighbouring samples; -1 to 1
  // outliers: a sample is one with this probability; then N(0, (size sigma)^2) is added to each of
  // its axes, sigma that of the scaled noise.
  double outlier_probability = 0.0, outlier_size = 0.0;
};

// e_k = rho e_k-1 + sqrt(1 - rho^2) w_k: every e_k has the standard deviation `sigma` (times the
// shape's scale), in the samples' unit. One seed is one sequence of w, whatever the shape.
void add_noise(std::vector<Vector3>& samples, double sigma, const NoiseShape& shape,
               std::uint64_t seed);

// mains_interference: a cos(2 pi f t) + d sin(2 pi f t), in the sensor's axes.
struct Mains {
  Vector3 a = Vector3::Zero(), d = Vector3::Zero();  // uT
  double f_hz = 50.0;                                // may be above half the sampling rate
  // In whose frame a and d are: the sensor's, where a line or a motor beside it makes them, or n,
  // where the room does.
  bool of_room = false;

  Vector3 at(double t) const;  // t in s; in that frame
};

// mag_quantization: q round(x / q); q = 0 leaves the samples as they are.
void quantize(std::vector<Vector3>& samples, double q);

// mag_saturation: every axis clamped to +-M.
void saturate(std::vector<Vector3>& samples, double most);

}  // namespace magimu
