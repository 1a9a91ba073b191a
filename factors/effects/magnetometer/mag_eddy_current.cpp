// SPDX-License-Identifier: BSD-3-Clause
// mag + E (omega x b): currents that turning induces in metal nearby.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagEddyCurrent final : public Effect {
 public:
  MagEddyCurrent()
      : Effect({.name = "mag_eddy_current",
                .channel = Sensor::kMag,
                .parameters = matrix_parameters("E", "uT s", 0.5),
                .cause = "turning induces currents in metal near the magnetometer",
                .contains = {"mag_time_offset", "mag_lag", "mag_axis_time_offset"},
                .separating_motion = "turn fast about each axis in turn"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    matrix_jacobian(s.omega.cross(s.b), J);
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_eddy_current() { return std::make_unique<MagEddyCurrent>(); }

}  // namespace magimu
