// SPDX-License-Identifier: BSD-3-Clause
// mag = h(t - delay) averaged over the past: v is the variance of the readings' ages, which is all
// that a filter shows to second order beside its delay. tau^2 of a filter of first order, W^2 / 12
// of a mean over W; below 0 where a filter overshoots.
#include "factors/effects/bandwidth.h"
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagBandwidth final : public Effect {
 public:
  MagBandwidth()
      : Effect({.name = "mag_bandwidth",
                .channel = Sensor::kMag,
                .parameters = {{"v", "s^2", kUsualSpread * kUsualSpread}},
                .cause = "the magnetometer averages over some time",
                .separating_motion = "turn fast, and start and stop abruptly"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    // s: a hand's motion hardly bends within, and slow gyroscopes have a sample in it.
    constexpr double kStep = 0.02;
    const auto b = [&](double beside) { return s.field_before(s.delay_s + beside); };
    J = 0.5 * s.D * ((b(kStep) + b(-kStep) - 2.0 * b(0.0)) / (kStep * kStep));
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    return bandwidth_sentence("magnetometer", theta[0], sigma[0]);
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_bandwidth() { return std::make_unique<MagBandwidth>(); }

}  // namespace magimu
