// SPDX-License-Identifier: BSD-3-Clause
// gyr_i + k_i omega_i |omega_i|.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class GyroNonlinearity final : public Effect {
 public:
  GyroNonlinearity()
      : Effect({.name = "gyro_nonlinearity",
                .channel = Sensor::kGyr,
                .parameters = vector_parameters("k", "s/rad", 0.01),
                .cause = "the gyroscope's scale depends on the rate",
                .separating_motion = "turn about each axis slowly and fast"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = (s.omega.array() * s.omega.array().abs()).matrix().asDiagonal().toDenseMatrix();
  }
};

}  // namespace

std::unique_ptr<Effect> make_gyro_nonlinearity() { return std::make_unique<GyroNonlinearity>(); }

}  // namespace magimu
