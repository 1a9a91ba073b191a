// SPDX-License-Identifier: BSD-3-Clause
// Noise and what follows it: degrade.h.
#include "tests/oracle/degrade.h"

#include <cmath>

#include "tests/oracle/random.h"

namespace magimu::oracle {
namespace {

using Samples = std::vector<Eigen::Vector3d>;

// e_k = rho e_k-1 + sqrt(1 - rho^2) w_k, stationary from the first sample on: of every e_k the
// variance is that of w_k.
void add_noise(Samples& samples, double sigma, double rho, Random random) {
  const double fresh = std::sqrt(1.0 - rho * rho);
  Eigen::Vector3d e = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Eigen::Vector3d w = random.normal3();
    e = k == 0 ? w : Eigen::Vector3d(rho * e + fresh * w);
    samples[k] += sigma * e;
  }
}

void add_outliers(Samples& samples, double probability, double sigma, Random random) {
  for (Eigen::Vector3d& sample : samples) {
    const bool hit = random.uniform() < probability;
    const Eigen::Vector3d error = random.normal3();
    if (hit) sample += sigma * error;
  }
}

void quantize(Samples& samples, double step) {
  if (!(step > 0.0)) return;
  for (Eigen::Vector3d& sample : samples) sample = step * (sample / step).array().round();
}

void clip(Samples& samples, double most) {
  for (Eigen::Vector3d& sample : samples) sample = sample.cwiseMin(most).cwiseMax(-most);
}

void repeat(Samples& samples, double probability, Random random) {
  for (std::size_t k = 1; k < samples.size(); ++k) {
    if (random.uniform() < probability) samples[k] = samples[k - 1];
  }
}

}  // namespace

void degrade(Samples& samples, Channel channel, double sigma, const std::vector<Effect>& effects,
             std::uint64_t seed) {
  const auto stream = [&](Stream s) {
    return Random(seed, s, static_cast<std::uint64_t>(channel));
  };
  const auto each = [&](EffectKind kind, auto&& action) {
    for (const Effect& e : effects) {
      const bool magnetic =
          kind == EffectKind::kMagQuantization || kind == EffectKind::kMagSaturation;
      if (e.kind == kind && channel == (magnetic ? Channel::kMag : e.channel)) action(e);
    }
  };
  double rho = 0.0;
  each(EffectKind::kNoiseScale, [&](const Effect& e) { sigma *= e[0]; });
  each(EffectKind::kCorrelatedNoise, [&](const Effect& e) { rho = e[0]; });
  add_noise(samples, sigma, rho, stream(Stream::kNoise));
  each(EffectKind::kOutliers, [&](const Effect& e) {
    add_outliers(samples, e[0], e[1] * sigma, stream(Stream::kOutliers));
  });
  each(EffectKind::kMagQuantization, [&](const Effect& e) { quantize(samples, e[0]); });
  each(EffectKind::kMagSaturation, [&](const Effect& e) { clip(samples, e[0]); });
  each(EffectKind::kSampleRepetition,
       [&](const Effect& e) { repeat(samples, e[0], stream(Stream::kRepetition)); });
}

}  // namespace magimu::oracle
