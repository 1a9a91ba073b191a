// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/simulated_noise.h"

#include <cmath>

namespace magimu {

namespace {

// One sensor's samples: coloured or heavy-tailed noise, in units of its Gaussian core.
class Samples {
 public:
  explicit Samples(const SimulatedNoise::OfSensor& s) : s_(s) {}

  void begin(int recording) {
    first_ = first_ || recording != recording_;
    recording_ = recording;
  }

  Vector3 next(std::mt19937_64& random) {
    Vector3 x = gaussian(random);
    if (s_.eps > 0.0 && uniform_(random) < s_.eps) x += s_.K * gaussian(random);
    state_ = first_ ? x : Vector3(s_.rho * state_ + std::sqrt(1.0 - s_.rho * s_.rho) * x);
    first_ = false;
    return state_;
  }

 private:
  Vector3 gaussian(std::mt19937_64& random) {
    return {normal_(random), normal_(random), normal_(random)};
  }

  const SimulatedNoise::OfSensor& s_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
  Vector3 state_ = Vector3::Zero();
  int recording_ = -1;
  bool first_ = true;
};

// Of a sample, in units of its core.
double variance_of_sample(const SimulatedNoise::OfSensor& s) { return 1.0 + s.eps * s.K * s.K; }

// Of a mean of n samples: the sum over all pairs of rho^|i - j|, over n^2.
double variance_of_mean(const SimulatedNoise::OfSensor& s) {
  const int n = s.samples;
  double variance = double(n);
  for (int lag = 1; lag < n; ++lag) variance += 2.0 * (n - lag) * std::pow(s.rho, lag);
  return variance * variance_of_sample(s) / (double(n) * n);
}

// Means of coloured or heavy-tailed samples. Their standard deviation is 1; where the density of
// the Gaussian core was given, it is that of the whole noise over the core's.
void add_shaped(const SimulatedNoise::OfSensor& s, std::mt19937_64& random, VectorXd& e) {
  const double unit = s.given ? 1.0 / std::sqrt(double(s.samples)) : std::sqrt(variance_of_mean(s));
  Samples samples(s);
  for (std::size_t k = 0; k < s.sensor->rows().size(); ++k) {
    samples.begin(s.sensor->recording_of_rows()[k]);
    Vector3 mean = Vector3::Zero();
    for (int i = 0; i < s.samples; ++i) mean += samples.next(random) / double(s.samples);
    e.segment<3>(s.sensor->rows()[k]) = mean / unit;
  }
}

// Means of samples that were rounded to the converter's steps. In slow motion rounding errors are
// correlated in time.
void add_rounded(const SimulatedNoise::OfSensor& s, std::mt19937_64& random, VectorXd& e) {
  // The prediction is less well known than one step: its place between two steps is drawn.
  std::uniform_real_distribution<double> phase(-0.5 * s.step, 0.5 * s.step);
  const Vector3 offset(phase(random), phase(random), phase(random));
  const double before = s.before / std::sqrt(variance_of_sample(s));
  Samples samples(s);
  for (std::size_t k = 0; k < s.sensor->rows().size(); ++k) {
    if (s.predicted[k].empty()) continue;
    samples.begin(s.sensor->recording_of_rows()[k]);
    Vector3 sum = Vector3::Zero();
    for (const Vector3& exact : s.predicted[k]) {
      const Vector3 p = exact + offset, noise = before * samples.next(random);
      for (int i = 0; i < 3; ++i) sum[i] += s.step * std::round((p[i] + noise[i]) / s.step) - p[i];
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
    if (!s.predicted.empty()) {
      add_rounded(s, random, e);
    } else if (s.rho != 0.0 || s.eps > 0.0) {
      add_shaped(s, random, e);
    }
    if (s.scale == 1.0) continue;
    for (const int row : s.sensor->rows()) e.segment<3>(row) *= s.scale;
  }
  return e;
}

}  // namespace magimu
