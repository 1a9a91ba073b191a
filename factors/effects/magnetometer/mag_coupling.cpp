// SPDX-License-Identifier: BSD-3-Clause
// mag + C h', h' what a neighbour on the same board reads: magnetometers with a core or a coil
// carry on to each other what they measure. Mutual induction is the same both ways, so that the
// neighbour reads C' h more.
//
// In a field that is the same at both, C h' is a constant and a part of the own distortion, and
// nobody can tell: what shows there is the neighbour's noise (diagnosis/conclude/array_coupling.h).
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagCoupling final : public Effect {
 public:
  MagCoupling()
      : Effect({.name = "mag_coupling",
                .channel = Sensor::kMag,
                .parameters = matrix_parameters("C", "1", 0.05),
                .cause = "a magnetometer carries on to its neighbour what it reads",
                .separating_motion = "a long recording: it shows in the magnetometers' noise"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    matrix_jacobian(s.neighbour, J);
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_coupling() { return std::make_unique<MagCoupling>(); }

}  // namespace magimu
