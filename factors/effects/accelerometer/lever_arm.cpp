// SPDX-License-Identifier: BSD-3-Clause
// acc + omega' x r + omega x (omega x r), r from the pivot to the accelerometer.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class LeverArm final : public Effect {
 public:
  LeverArm()
      : Effect({.name = "lever_arm",
                .channel = Sensor::kAcc,
                .parameters = vector_parameters("r", "m", 0.1),
                .cause = "the accelerometer sits away from the point about which the device turns",
                .separating_motion = "turn fast and change direction quickly",
                .rotation_only = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = so3::hat(s.omega_rate) + so3::hat(s.omega) * so3::hat(s.omega);
  }
};

}  // namespace

std::unique_ptr<Effect> make_lever_arm() { return std::make_unique<LeverArm>(); }

}  // namespace magimu
