// SPDX-License-Identifier: BSD-3-Clause
// bias + c (T - mean T).
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagTemperature final : public Effect {
 public:
  MagTemperature()
      : Effect({.name = "mag_temperature",
                .channel = Sensor::kMag,
                .parameters = vector_parameters("c", "uT/K", 0.5),
                .cause = "the magnetometer's bias follows the temperature",
                .needs = "temp",
                .separating_motion = "record while the device warms up, at different orientations",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = s.temperature * Matrix3::Identity();
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_temperature() { return std::make_unique<MagTemperature>(); }

}  // namespace magimu
