// SPDX-License-Identifier: BSD-3-Clause
// Sizes of hidden effects and the strengths that have them: effect_sizes.h.
#include "bench/power/effect_sizes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bench/power/effect_strength.h"
#include "calibration/calibrate.h"
#include "study/error_statistics.h"

namespace magimu {
namespace {

using oracle::EffectKind;

constexpr double kReference = 60.0;  // size from which linear effects are scaled
constexpr double kVisible = 1e-6;    // smaller sizes are rounding

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
    const oracle::Simulation simulated = oracle::simulate(options_);
    for (const Vector3& m : simulated.recording.mag.front().v) {
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
    Recording recording = oracle::simulate(o).recording;
    // The misfit of all samples is the size, clipped ones among them: a recording that says what
    // was set aside passes the gate as it is.
    recording.set_aside.emplace_back().sensor = "mag";
    Calibration c = calibrate(recording, options);
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
    const double times = std::max(size / m.size, least_times() / m.times);
    size = times * m.size;
    return {m.times * times, size, m.bias_sigma * times};
  }
  HiddenCase apply(const HiddenCase& c, double size) {
    return at_strength(c, sizer_, index_, of(size));
  }

 private:
  // No magnetometer measures more than a thousand times a second.
  double least_times() const {
    constexpr double kShortestPeriod = 1e-3;  // s
    if (sizer_.moves()) return 0.0;
    const oracle::Effect& effect = case_.options.effects[index_];
    return effect.kind == oracle::EffectKind::kMagOwnClock ? kShortestPeriod / effect.parameters[0]
                                                           : 0.0;
  }
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
