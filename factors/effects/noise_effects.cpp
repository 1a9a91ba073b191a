// SPDX-License-Identifier: BSD-3-Clause
// Noise-like effects: noise_effects.h.
#include "factors/effects/noise_effects.h"

#include <cmath>
#include <numbers>

namespace magimu {
namespace {

// Numbers that are the same everywhere, by their place in the sequence: what one purpose draws
// leaves the other's as they were.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t purpose) : state_(mix(mix(seed) + purpose)) {}

  double uniform() {  // on (0, 1)
    state_ += 0x9E3779B97F4A7C15u;
    return (static_cast<double>(mix(state_) >> 11) + 0.5) * 0x1p-53;
  }
  Vector3 normal3() {  // Box and Muller; the fourth number is not used
    const double r = std::sqrt(-2.0 * std::log(uniform())),
                 s = std::sqrt(-2.0 * std::log(uniform()));
    const double phi = 2.0 * std::numbers::pi * uniform(), psi = 2.0 * std::numbers::pi * uniform();
    return {r * std::cos(phi), r * std::sin(phi), s * std::cos(psi)};
  }

 private:
  // SplitMix64 (Steele, Lea and Flood 2014).
  static constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
  }
  std::uint64_t state_;
};

}  // namespace

void add_noise(std::vector<Vector3>& samples, double sigma, const NoiseShape& shape,
               std::uint64_t seed) {
  Draws noise(seed, 1), outliers(seed, 2);
  const double scaled = sigma * shape.scale, rho = shape.correlation;
  const double fresh = std::sqrt(1.0 - rho * rho);
  Vector3 e = Vector3::Zero();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Vector3 w = noise.normal3();
    e = k == 0 ? w : Vector3(rho * e + fresh * w);
    samples[k] += scaled * e;
    const bool hit = outliers.uniform() < shape.outlier_probability;
    const Vector3 far = outliers.normal3();
    if (hit) samples[k] += scaled * shape.outlier_size * far;
  }
}

Vector3 Mains::at(double t) const {
  const double phase = 2.0 * std::numbers::pi * f_hz * t;
  return a * std::cos(phase) + d * std::sin(phase);
}

void quantize(std::vector<Vector3>& samples, double q) {
  if (!(q > 0.0)) return;
  for (Vector3& sample : samples) sample = q * (sample / q).array().round();
}

void saturate(std::vector<Vector3>& samples, double most) {
  for (Vector3& sample : samples) sample = sample.cwiseMin(most).cwiseMax(-most);
}

}  // namespace magimu
