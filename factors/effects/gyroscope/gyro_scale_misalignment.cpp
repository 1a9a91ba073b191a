// SPDX-License-Identifier: BSD-3-Clause
// gyr = (I + S) omega + o_w.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class GyroScaleMisalignment final : public Effect {
 public:
  GyroScaleMisalignment()
      : Effect({.name = "gyro_scale_misalignment",
                .channel = Sensor::kGyr,
                .parameters = matrix_parameters("S", "1", 0.02),
                .cause = "the gyroscope's axes have scale errors or are not those of the IMU",
                .contains = {"clock_scale"},
                .separating_motion = "turn by several full turns about each axis in turn"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    matrix_jacobian(s.omega, J);
  }
};

}  // namespace

std::unique_ptr<Effect> make_gyro_scale_misalignment() {
  return std::make_unique<GyroScaleMisalignment>();
}

}  // namespace magimu
