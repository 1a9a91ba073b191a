// SPDX-License-Identifier: BSD-3-Clause
// gyr + G f.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class GyroGSensitivity final : public Effect {
 public:
  GyroGSensitivity()
      : Effect({.name = "gyro_g_sensitivity",
                .channel = Sensor::kGyr,
                .parameters = matrix_parameters("G", "(rad/s)/(m/s^2)", 1e-3),
                .cause = "the gyroscope responds to gravity and acceleration",
                .separating_motion = "hold every face of the sensor up for some seconds",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    matrix_jacobian(s.f, J);
  }
};

}  // namespace

std::unique_ptr<Effect> make_gyro_g_sensitivity() { return std::make_unique<GyroGSensitivity>(); }

}  // namespace magimu
