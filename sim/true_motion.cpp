// SPDX-License-Identifier: BSD-3-Clause
#include "sim/true_motion.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kAtSample = 1e-6;  // of an interval

double own_rest_s(SimulatedMotion motion) {
  if (motion == SimulatedMotion::kPaper) return 0.0;
  return motion == SimulatedMotion::kSequence ? TurnSequence::kRest : HandMotion::kRest;
}

double own_moving_s(SimulatedMotion motion) {
  if (motion == SimulatedMotion::kPaper) return paper_motion_duration_s();
  return motion == SimulatedMotion::kSequence ? TurnSequence::kDuration - TurnSequence::kRest
                                              : HandMotion::kDuration - HandMotion::kRest;
}

}  // namespace

TrueMotion::TrueMotion(const SimulationOptions& o, double clock) : rate_hz_(o.rate_hz / clock) {
  const double rest = o.rest_s >= 0.0 ? o.rest_s : own_rest_s(o.motion);
  const double duration = o.duration_s > 0.0 ? o.duration_s : rest + own_moving_s(o.motion);
  if (o.follow) {
    followed_.emplace(*o.follow, duration * clock);
    motion_ = sample_motion(
        followed_->initial_nRb(), [this](double t) { return continuous_rate(t); }, rate_hz_,
        duration * clock);
  } else if (o.motion == SimulatedMotion::kPaper) {
    // The file's duration: as many samples, whatever its clock.
    motion_ = paper_motion(o.seed, rate_hz_, duration * clock, rest);
  } else {
    const bool moved = o.motion == SimulatedMotion::kHandHeld;
    if (o.motion == SimulatedMotion::kSequence) {
      sequence_.emplace(o.seed, duration, rest);
    } else {
      hand_.emplace(o.seed, duration, rest, moved);
    }
    if (moved) path_.emplace(o.seed, hand_->stretches(), o.displacement_m);
    if (moved && o.speed_mps > 0.0) travel_.emplace(o.seed, hand_->stretches(), o.speed_mps);
    motion_ = sample_motion(
        hand_ ? hand_->initial_nRb() : sequence_->initial_nRb(),
        [this](double t) { return continuous_rate(t); }, rate_hz_, duration * clock);
  }
  nRb_ = integrate(motion_, rate_hz_);
}

Vector3 TrueMotion::continuous_rate(double t) const {
  if (followed_) return followed_->omega(t);
  return hand_ ? hand_->omega(t) : sequence_->omega(t);
}

Vector3 TrueMotion::place(double t, int derivative) const {
  if (followed_) return followed_->position(t, derivative);
  if (!path_) return Vector3::Zero();
  const auto of = [&](const auto& path) {
    return derivative == 0   ? path.position(t)
           : derivative == 1 ? path.velocity(t)
                             : path.acceleration(t);
  };
  return travel_ ? Vector3(of(*path_) + of(*travel_)) : of(*path_);
}

Rot3 TrueMotion::attitude(double t) const {
  if (!(t > 0.0)) return nRb_.front();
  const auto k = std::min(static_cast<std::size_t>(t * rate_hz_ + kAtSample), samples() - 1);
  const double since = t - time(k);
  if (std::abs(since) * rate_hz_ <= kAtSample) return nRb_[k];
  if (!continuous()) return (nRb_[k] * Rot3::Exp(since * mean_rate()[k])).normalized();
  return (nRb_[k] * turn_between([this](double at) { return continuous_rate(at); }, time(k), t))
      .normalized();
}

TrueMotion::Step TrueMotion::step(double t) const {
  const double x = t * rate_hz_;
  const auto rate = [this](double interval) -> const Vector3& {
    const double last = static_cast<double>(samples() - 1);
    return mean_rate()[static_cast<std::size_t>(std::clamp(interval, 0.0, last))];
  };
  const double nearest = std::round(x);
  if (std::abs(x - nearest) <= kAtSample) return {rate(nearest - 1.0), rate(nearest)};
  return {rate(std::floor(x)), rate(std::floor(x))};
}

Vector3 TrueMotion::omega(double t) const {
  if (continuous()) return continuous_rate(t);
  const Step s = step(t);
  return 0.5 * (s.before + s.after);
}

Vector3 TrueMotion::omega_rate(double t) const {
  if (followed_) return followed_->omega_rate(t);
  if (hand_) return hand_->omega_rate(t);
  if (sequence_) return sequence_->omega_rate(t);
  const Step s = step(t);
  return (s.after - s.before) * rate_hz_;
}

}  // namespace magimu
