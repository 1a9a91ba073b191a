// SPDX-License-Identifier: BSD-3-Clause
// Stronger and weaker effects, and sizes of noise: effect_strength.h.
#include "bench/power/effect_strength.h"

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

// Of outliers, where a blow's 15 ms are the share of samples that it hits and the mean square of
// its damped sine, each axis, is K^2 (sizes are drawn from 0.3 to 1 of the effect's).
double tapping_divergence(double per_s, double size, double sigma) {
  constexpr double kSeconds = 0.015, kSquares = 0.463, kSineSquared = 0.00216;  // the last in s
  const double eps = std::min(0.5, per_s * kSeconds);
  const double variance = per_s * size * size * kSquares * kSineSquared / 3.0;
  return outlier_divergence(eps, std::sqrt(variance / eps) / sigma);
}

// Of times that are off by N(0, jitter^2), from noise of one size: the exact recording tells how
// fast each sample changes.
double jitter_size_squared(double jitter_s, double sigma, oracle::Options o) {
  o.effects.clear();
  o.noise_factor = 0.0;
  const VectorSeries mag = oracle::simulate(o).recording.mag.front();
  double sum = 0.0, logs = 0.0, n = 0.0;
  for (std::size_t k = 1; k + 1 < mag.size(); ++k) {
    const Vector3 change = (mag.v[k + 1] - mag.v[k - 1]) / (mag.t[k + 1] - mag.t[k - 1]);
    const double added = change.squaredNorm() * std::pow(jitter_s / sigma, 2);
    sum += added;
    logs += std::log1p(added);
    n += 1.0;
  }
  return std::max(0.0, 3.0 * n * std::log1p(sum / n / 3.0) - logs);
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
    case EffectKind::kAccTapping:
      return samples * tapping_divergence(e[0], e[1], o.noise.acc * std::sqrt(rate));
    case EffectKind::kMagTimeJitter:
      return jitter_size_squared(e[0], o.noise.mag * std::sqrt(rate), o);
    default:
      return std::nullopt;
  }
}

bool proportional(EffectKind kind) {
  return kind != EffectKind::kMagSaturation && kind != EffectKind::kAccHysteresis &&
         kind != EffectKind::kMagHysteresis && kind != EffectKind::kSampleRepetition;
}

oracle::Effect scaled(const oracle::Effect& effect, double times, double largest) {
  oracle::Effect e = effect;
  switch (e.kind) {
    case EffectKind::kHardIronChange:
    case EffectKind::kAccBiasChange:
    case EffectKind::kGyroBiasChange:
    case EffectKind::kFieldChange:
      e.parameters.head<3>() *= times;  // their times stay
      break;
    case EffectKind::kMagGainChange:
    case EffectKind::kGyroGainChange:
    case EffectKind::kMagBoardTurn:
    case EffectKind::kPassingPhone:    // its way stays
    case EffectKind::kMotorCurrent:    // its speed and times stay
    case EffectKind::kLastTurnOffset:  // its axis stays
      e.parameters.head<3>() *= times;
      break;
    case EffectKind::kMagOwnClock:
      e.parameters[0] *= times;  // its share stays
      break;
    case EffectKind::kSoftIronChange:
    case EffectKind::kMagChange:  // their times stay
    case EffectKind::kGyroChange:
    case EffectKind::kAccChange:
      e.parameters.head<9>() *= times;
      break;
    case EffectKind::kSecondDevice:
      e.parameters.head<12>() *= times;
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
