// SPDX-License-Identifier: BSD-3-Clause
// Sizes of hidden effects and the strengths that have them: effect_sizes.h.
#include "bench/effect_sizes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "bench/error_statistics.h"
#include "calibration/calibrate.h"

namespace magimu {
namespace {

using oracle::EffectKind;

constexpr double kReference = 60.0;  // size from which linear effects are scaled
constexpr double kVisible = 1e-6;    // smaller sizes are rounding

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

// size^2 of what changes the noise alone; nothing for other effects.
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

// Readings change in proportion to what scaled() multiplies.
bool proportional(EffectKind kind) {
  return kind != EffectKind::kMagSaturation && kind != EffectKind::kAccHysteresis &&
         kind != EffectKind::kSampleRepetition;
}

struct Measure {
  double times = 1.0, size = 0.0, bias_sigma = 0.0;
};

// One effect of a case, the others left out, at any strength.
class Sizer {
 public:
  Sizer(const HiddenCase& c, std::size_t index) : options_(c.options) {
    motion_ = c.moved() ? MotionModel::kHandHeld : MotionModel::kRotation;
    if (c.hidden[index] == "linear_acceleration") {
      motion_ = MotionModel::kRotation;
      return;
    }
    effect_ = c.options.effects[index];
    options_.effects.clear();
    options_.noise_factor = 0.0;
    if (effect_->kind != EffectKind::kMagSaturation) return;
    for (const Vector3& m : oracle::simulate(options_).recording.mag.front().v) {
      largest_ = std::max(largest_, m.cwiseAbs().maxCoeff());
    }
  }

  bool moves() const { return !effect_; }
  bool linear() const { return effect_ && proportional(effect_->kind); }
  oracle::Effect effect(double times) const { return scaled(*effect_, times, largest_); }

  Measure at(double times) {
    Measure m{.times = times};
    if (effect_) {
      if (const auto square = noise_size_squared(effect(times), options_)) {
        m.size = std::sqrt(*square);
        return m;
      }
    }
    if (!without_) without_ = calibrated(0.0);
    const Calibration with = calibrated(times);
    double square = 2.0 * (with.fit.cost_final - without_->fit.cost_final);
    if (moves()) {
      const MotionOptions& o = options_.motion;
      const double unknowns = 6.0 * (o.band_hz[1] - o.band_hz[0]) * o.duration_s;
      const double r = std::max(0.0, square) / unknowns;
      square = unknowns * (r - std::log1p(r));
    }
    m.size = std::sqrt(std::max(0.0, square));
    const VectorXd shift = in_calibration_order(with) - in_calibration_order(*without_);
    const VectorXd sigma = without_->covariance_model.diagonal().cwiseSqrt();
    m.bias_sigma = (shift.array().abs() / sigma.array().max(1e-300)).maxCoeff();
    return m;
  }

 private:
  using MotionOptions = oracle::MotionOptions;

  Calibration calibrated(double times) const {
    oracle::Options o = options_;
    o.noise_factor = 0.0;
    o.record_pos = o.record_temp = o.record_current = false;
    if (moves()) {
      o.motion.displacement_m *= times;
    } else if (times > 0.0) {
      o.effects = {effect(times)};
    }
    CalibrationOptions options;
    options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
    options.gravity = o.gravity;
    options.motion = motion_;
    options.mag_time_offset = false;
    options.gyr_matrix = false;
    Calibration c = calibrate(oracle::simulate(o).recording, options);
    c.trajectories.clear();
    c.fit.values = {};
    return c;
  }

  oracle::Options options_;
  std::optional<oracle::Effect> effect_;  // none: linear_acceleration
  MotionModel motion_ = MotionModel::kRotation;
  double largest_ = 0.0;
  std::optional<Calibration> without_;
};

// The strength of this size, by secants of log size over log strength from one that is known.
Measure solve(Sizer& sizer, Measure m, double target) {
  const auto near = [&](double s) { return std::abs(std::log(s / target)) < 0.04; };
  double slope = 1.0;
  for (int i = 0; i < 12 && m.size > kVisible && !near(m.size); ++i) {
    const double step = std::clamp(std::log(target / m.size) / slope, -6.0, 6.0);
    const Measure next = sizer.at(m.times * std::exp(step));
    if (next.size > kVisible) {
      slope = std::clamp(std::log(next.size / m.size) / step, 0.3, 4.0);
    }
    m = next;
  }
  return m;
}

// Proportional effects are measured once, where the size is large beside rounding and small beside
// what bends.
Measure reference(Sizer& sizer, Measure m) {
  for (int i = 0; i < 3 && m.size > kVisible; ++i) {
    if (m.size > 0.5 * kReference && m.size < 1.5 * kReference) break;
    m = sizer.at(m.times * kReference / m.size);
  }
  return m;
}

HiddenCase at_strength(HiddenCase c, const Sizer& sizer, std::size_t index, const Measure& m) {
  if (sizer.moves()) {
    c.options.motion.displacement_m *= m.times;
  } else {
    c.options.effects[index] = sizer.effect(m.times);
  }
  c.sizes.resize(c.hidden.size());
  c.sizes[index] = m.size;
  c.bias_sigma = std::max(c.bias_sigma, m.bias_sigma);
  return c;
}

class Strengths {
 public:
  Strengths(const HiddenCase& c, std::size_t index)
      : case_(c), index_(index), sizer_(c, index), real_(sizer_.at(1.0)) {}

  // 0: as drawn.
  Measure of(double size) {
    if (size <= 0.0 || real_.size <= kVisible) return real_;
    if (!sizer_.linear() || noise()) return solve(sizer_, real_, size);
    if (!reference_) reference_ = reference(sizer_, real_);
    Measure m = *reference_;
    const double times = size / m.size;
    return {m.times * times, size, m.bias_sigma * times};
  }
  HiddenCase apply(const HiddenCase& c, double size) {
    return at_strength(c, sizer_, index_, of(size));
  }

 private:
  bool noise() const {
    return !sizer_.moves() && noise_size_squared(case_.options.effects[index_], case_.options);
  }

  const HiddenCase& case_;
  std::size_t index_;
  Sizer sizer_;
  Measure real_;
  std::optional<Measure> reference_;
};

}  // namespace

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

HiddenCase measured(HiddenCase c) {
  for (std::size_t i = 0; i < c.hidden.size(); ++i) c = Strengths(HiddenCase(c), i).apply(c, 0.0);
  return c;
}

std::vector<HiddenCase> with_sizes(const HiddenCase& c, const std::vector<double>& sizes) {
  Strengths strengths(c, 0);
  std::vector<HiddenCase> cases;
  for (const double size : sizes) cases.push_back(strengths.apply(c, size));
  return cases;
}

HiddenCase pair_with_size(HiddenCase c, double size) {
  for (std::size_t i = 0; i < c.hidden.size(); ++i) {
    const HiddenCase before = c;
    c = Strengths(before, i).apply(c, size);
  }
  return c;
}

}  // namespace magimu
