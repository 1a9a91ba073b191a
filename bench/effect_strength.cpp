// SPDX-License-Identifier: BSD-3-Clause
// Stronger and weaker effects, and sizes of noise: effect_strength.h.
#include "bench/effect_strength.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace magimu {

using oracle::EffectKind;

namespace {

// 2 KL of one sample with outliers from the nearest normal: both depend on its length r only.
double outlier_divergence(double eps, double K) {
  const double wide = 1.0 + K * K, best = 1.0 + eps * K * K;
  const auto normal = [](double r2, double variance) {
    return std::pow(2.0 * std::numbers::pi * variance, -1.5) * std::exp(-0.5 * r2 / variance);
  };
  constexpr int kSteps = 4000;
  const double from = std::log(1e-3), to = std::log(12.0 * std::sqrt(wide));
  const double step = (to - from) / kSteps;
  double sum = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double r = std::exp(from + step * i), r2 = r * r;
    const double p = (1.0 - eps) * normal(r2, 1.0) + eps * normal(r2, wide);
    const double q = normal(r2, best);
    if (p > 1e-290 && q > 1e-290) {
      sum += 4.0 * std::numbers::pi * r2 * r * step * p * std::log(p / q);
    }
  }
  return std::max(0.0, 2.0 * sum);
}

double scale_divergence(double variance) { return variance - 1.0 - std::log(variance); }

}  // namespace

std::optional<double> noise_size_squared(const oracle::Effect& e, const oracle::Options& o) {
  const bool slow = e.channel == oracle::Channel::kMag && o.mag_rate_hz > 0.0;
  const double rate = slow ? o.mag_rate_hz : o.rate_hz;
  const double samples = rate * o.motion.duration_s;
  switch (e.kind) {
    case EffectKind::kNoiseScale:
      return 3.0 * samples * scale_divergence(e[0] * e[0]);
    case EffectKind::kCorrelatedNoise:
      return -3.0 * samples * std::log1p(-e[0] * e[0]);
    case EffectKind::kMagQuantization: {
      const double sigma = o.noise.mag * std::sqrt(rate);
      return 3.0 * samples * scale_divergence(1.0 + e[0] * e[0] / (12.0 * sigma * sigma));
    }
    case EffectKind::kOutliers:
      return samples * outlier_divergence(e[0], e[1]);
    default:
      return std::nullopt;
  }
}

bool proportional(EffectKind kind) {
  return kind != EffectKind::kMagSaturation && kind != EffectKind::kAccHysteresis &&
         kind != EffectKind::kSampleRepetition;
}

oracle::Effect scaled(const oracle::Effect& effect, double times, double largest) {
  oracle::Effect e = effect;
  switch (e.kind) {
    case EffectKind::kHardIronChange:
      e.parameters.head<3>() *= times;  // its times stay
      break;
    case EffectKind::kMainsInterference:
      e.parameters.head<6>() *= times;  // its frequency stays
      break;
    case EffectKind::kStationarySource:
      e.parameters.tail<3>() *= times;  // its place stays
      break;
    case EffectKind::kNoiseScale:
      e.parameters[0] = 1.0 + (e[0] - 1.0) * times;
      break;
    case EffectKind::kCorrelatedNoise: {
      // atanh: any strength has a correlation below 1.
      e.parameters[0] = std::tanh(times * std::atanh(e[0]));
      break;
    }
    case EffectKind::kOutliers:
      e.parameters[1] *= times;
      break;
    case EffectKind::kMagMemory:
      e.parameters[0] *= times;
      break;
    case EffectKind::kAccTapping:
      e.parameters[1] *= times;
      break;
    case EffectKind::kSampleRepetition:
      e.parameters[0] = std::min(0.9, e[0] * times);
      break;
    case EffectKind::kMagSaturation:
      e.parameters[0] = std::max(0.05 * largest, largest - (largest - e[0]) * times);
      break;
    default:
      e.parameters *= times;
  }
  return e;
}

}  // namespace magimu
