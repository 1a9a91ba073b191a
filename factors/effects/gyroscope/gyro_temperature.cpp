// SPDX-License-Identifier: BSD-3-Clause
// bias + c (T - mean T).
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class GyroTemperature final : public Effect {
 public:
  GyroTemperature()
      : Effect({.name = "gyro_temperature",
                .channel = Sensor::kGyr,
                .parameters = vector_parameters("c", "rad/s/K", 0.002),
                .cause = "the gyroscope's bias follows the temperature",
                .needs = "temp",
                .separating_motion = "record while the device warms up, at different orientations",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = s.temperature * Matrix3::Identity();
  }
};

}  // namespace

std::unique_ptr<Effect> make_gyro_temperature() { return std::make_unique<GyroTemperature>(); }

}  // namespace magimu
