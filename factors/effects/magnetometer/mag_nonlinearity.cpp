// SPDX-License-Identifier: BSD-3-Clause
// mag_i + k_i B_i^3 / (50 uT)^2, B = D b.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagNonlinearity final : public Effect {
 public:
  MagNonlinearity()
      : Effect({.name = "mag_nonlinearity",
                .channel = Sensor::kMag,
                .parameters = vector_parameters("k", "1", 0.05),
                .cause =
                    "the magnetometer's scale depends on the strength of the field along the axis",
                .separating_motion = "point each axis along and against the field"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    constexpr double kReference = 50.0;  // uT
    const Vector3 B = s.D * s.b;
    J = (B.array().cube() / (kReference * kReference)).matrix().asDiagonal().toDenseMatrix();
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_nonlinearity() { return std::make_unique<MagNonlinearity>(); }

}  // namespace magimu
