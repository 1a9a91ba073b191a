// SPDX-License-Identifier: BSD-3-Clause
// mag + c I(t): the field of a wire on the board.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagCurrent final : public Effect {
 public:
  MagCurrent()
      : Effect({.name = "mag_current",
                .channel = Sensor::kMag,
                .parameters = vector_parameters("c", "uT/A", 3.0),
                .cause = "a current on the device makes a field of its own",
                .needs = "current",
                .separating_motion = "switch the load on and off while turning",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = s.current * Matrix3::Identity();
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_current() { return std::make_unique<MagCurrent>(); }

}  // namespace magimu
