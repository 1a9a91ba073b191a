// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/simulated_noise.h"

#include <cmath>

namespace magimu {

namespace {

// Means of coloured or heavy-tailed samples, of one standard deviation.
void add_shaped(const SimulatedNoise::OfSensor& s, std::mt19937_64& random, VectorXd& e) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  // The variance of a mean of n samples: sum over all pairs of rho^|i - j|, over n^2.
  const int n = s.samples;
  double variance = double(n);
  for (int lag = 1; lag < n; ++lag) variance += 2.0 * (n - lag) * std::pow(s.rho, lag);
  variance *= (1.0 + s.eps * s.K * s.K) / (double(n) * n);
  Vector3 state = Vector3::Zero();
  int recording = -1;
  for (std::size_t k = 0; k < s.sensor->rows().size(); ++k) {
    Vector3 mean = Vector3::Zero();
    for (int i = 0; i < n; ++i) {
      Vector3 x(normal(random), normal(random), normal(random));
      if (s.eps > 0.0 && uniform(random) < s.eps) {
        x += s.K * Vector3(normal(random), normal(random), normal(random));
      }
      const bool first = s.sensor->recording_of_rows()[k] != recording;
      recording = s.sensor->recording_of_rows()[k];
      state = first ? x : Vector3(s.rho * state + std::sqrt(1.0 - s.rho * s.rho) * x);
      mean += state / double(n);
    }
    e.segment<3>(s.sensor->rows()[k]) = mean / std::sqrt(variance);
  }
}

// Means of samples that were rounded to the converter's steps. In slow motion rounding errors are
// correlated in time.
void add_rounded(const SimulatedNoise::OfSensor& s, std::mt19937_64& random, VectorXd& e) {
  std::normal_distribution<double> normal;
  // Where between two steps the prediction lies is known less well than to a step.
  std::uniform_real_distribution<double> phase(-0.5 * s.step, 0.5 * s.step);
  const Vector3 offset(phase(random), phase(random), phase(random));
  for (std::size_t k = 0; k < s.sensor->rows().size(); ++k) {
    if (s.predicted[k].empty()) continue;
    Vector3 sum = Vector3::Zero();
    for (const Vector3& exact : s.predicted[k]) {
      const Vector3 p = exact + offset;
      for (int i = 0; i < 3; ++i) {
        sum[i] += s.step * std::round((p[i] + s.before * normal(random)) / s.step) - p[i];
      }
    }
    e.segment<3>(s.sensor->rows()[k]) = sum / (std::sqrt(double(s.predicted[k].size())) * s.sigma);
  }
}

}  // namespace

SimulatedNoise::SimulatedNoise(VectorXd residual, std::vector<OfSensor> sensors)
    : residual_(std::move(residual)), sensors_(std::move(sensors)) {}

VectorXd SimulatedNoise::draw(std::mt19937_64& random) const {
  std::normal_distribution<double> normal;
  VectorXd e = residual_;
  for (const OfSensor& s : sensors_) {
    for (const int row : s.sensor->rows()) {
      for (int i = 0; i < 3; ++i) e[row + i] = normal(random);
    }
    if (s.rho != 0.0 || s.eps > 0.0) add_shaped(s, random, e);
    if (!s.predicted.empty()) add_rounded(s, random, e);
    if (s.scale == 1.0) continue;
    for (const int row : s.sensor->rows()) e.segment<3>(row) *= s.scale;
  }
  return e;
}

}  // namespace magimu
