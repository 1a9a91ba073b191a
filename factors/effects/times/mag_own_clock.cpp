// SPDX-License-Identifier: BSD-3-Clause
// mag = h(t - phase(t)): the magnetometer measures on a clock of its own, every T seconds, and is
// read on another. What is read is up to T old, a sawtooth:
//
//   phase(t) = T frac(t / T + p)
//
// Where the clock of the readings has nearly the same period, or where measurements of a slower
// magnetometer are given the time of the nearest reading, the age changes slowly from one reading
// to the next: a pattern that repeats itself. Period and share p come from a search
// (diagnosis/noise/own_clock.h); what a graph estimates is how far both are off.
#include <fmt/format.h>

#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagOwnClock final : public Effect {
 public:
  // The parameters count from these; middle_s: the time about which the period turns the sawtooth.
  MagOwnClock(double period_s, double share, double middle_s,
              std::vector<Parameter> parameters = {{"T", "s", 0.02}, {"p", "1", 1.0}})
      : Effect({.name = "mag_own_clock",
                .channel = Sensor::kMag,
                .parameters = std::move(parameters),
                .cause = "the magnetometer measures on a clock of its own and is read on another",
                .separating_motion = "turn fast"}),
        period_s_(period_s),
        share_(share),
        middle_s_(middle_s) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    J.setZero();
    const double T = period_s_ + theta[0];
    if (!(T > 0.0)) return;
    const double turns = turns_at(s.t, theta), frac = turns - std::floor(turns);
    // Between its jumps the sawtooth has the slope 1 in the time.
    const double by_period = frac - (s.t - middle_s_) / T;
    const Vector3 later = s.D * s.omega.cross(s.field_before(T * frac));
    J << by_period * later, T * later;
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    const double T = period_s_ + theta[0];
    if (!(T > 0.0)) return Vector3::Zero();
    const double turns = turns_at(s.t, theta);
    return s.D * (s.field_before(T * (turns - std::floor(turns))) - s.b);
  }

 private:
  // p is the share at time 0 whatever the middle is.
  double turns_at(double t, const VectorXd& theta) const {
    return (t - middle_s_) / (period_s_ + theta[0]) + middle_turns() + share_ + theta[1];
  }
  double middle_turns() const { return period_s_ > 0.0 ? middle_s_ / period_s_ : 0.0; }

  double period_s_, share_, middle_s_;
};

}  // namespace

std::unique_ptr<Effect> make_mag_own_clock() {
  return std::make_unique<MagOwnClock>(0.0, 0.0, 0.0);
}

std::shared_ptr<const Effect> make_own_clock_at(double period_s, double share, double middle_s,
                                                double period_sigma_s, double share_sigma) {
  return std::make_shared<MagOwnClock>(
      period_s, share, middle_s,
      std::vector<Effect::Parameter>{{"T_beyond", "s", period_sigma_s},
                                     {"p_beyond", "1", share_sigma}});
}

}  // namespace magimu
