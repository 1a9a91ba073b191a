// SPDX-License-Identifier: BSD-3-Clause
// m(alpha) + G (p - mean p) / strength in n, G symmetric and traceless.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class FieldGradient final : public Effect {
 public:
  FieldGradient()
      : Effect({.name = "field_gradient",
                .channel = Sensor::kMag,
                .parameters = {{"G[x][x]", "uT/m", 5.0},
                               {"G[y][y]", "uT/m", 5.0},
                               {"G[x][y]", "uT/m", 5.0},
                               {"G[x][z]", "uT/m", 5.0},
                               {"G[y][z]", "uT/m", 5.0}},
                .cause = "the field changes with the place",
                .needs = "pos",
                .separating_motion = "visit different places in the same orientation"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    const Vector3 p = s.position - s.position_mean;
    Eigen::Matrix<double, 3, 5> in_n;
    in_n << p.x(), 0.0, p.y(), p.z(), 0.0,  //
        0.0, p.y(), p.x(), 0.0, p.z(),      //
        -p.z(), -p.z(), 0.0, p.x(), p.y();
    J = s.D * s.nRb.matrix().transpose() * in_n / s.strength_uT;
  }
};

}  // namespace

std::unique_ptr<Effect> make_field_gradient() { return std::make_unique<FieldGradient>(); }

}  // namespace magimu
