// SPDX-License-Identifier: BSD-3-Clause
// bias + c (T - mean T).
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class AccTemperature final : public Effect {
 public:
  AccTemperature()
      : Effect({.name = "acc_temperature",
                .channel = Sensor::kAcc,
                .parameters = vector_parameters("c", "m/s^2/K", 0.02),
                .cause = "the accelerometer's bias follows the temperature",
                .needs = "temp",
                .separating_motion = "record while the device warms up, at different orientations",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = s.temperature * Matrix3::Identity();
  }
};

}  // namespace

std::unique_ptr<Effect> make_acc_temperature() { return std::make_unique<AccTemperature>(); }

}  // namespace magimu
