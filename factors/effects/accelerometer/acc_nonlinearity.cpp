// SPDX-License-Identifier: BSD-3-Clause
// acc_i + k_i f_i^3 / g^2: the accelerometer's scale depends on the force along the axis.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class AccNonlinearity final : public Effect {
 public:
  AccNonlinearity()
      : Effect({.name = "acc_nonlinearity",
                .channel = Sensor::kAcc,
                .parameters = vector_parameters("k", "1", 0.01),
                .cause = "the accelerometer's scale depends on the force along the axis",
                .separating_motion = "hold every face of the sensor up, and every edge",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    constexpr double kGravity = 9.80665;  // m/s^2
    J = Vector3(s.f.array().cube() / (kGravity * kGravity)).asDiagonal();
  }
};

}  // namespace

std::unique_ptr<Effect> make_acc_nonlinearity() { return std::make_unique<AccNonlinearity>(); }

}  // namespace magimu
