// SPDX-License-Identifier: BSD-3-Clause
// acc = (I + L) f + o_a, L lower triangular.
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class AccScaleMisalignment final : public Effect {
 public:
  AccScaleMisalignment()
      : Effect({.name = "acc_scale_misalignment",
                .channel = Sensor::kAcc,
                .parameters = {{"L[0][0]", "1", 0.02},
                               {"L[1][0]", "1", 0.02},
                               {"L[1][1]", "1", 0.02},
                               {"L[2][0]", "1", 0.02},
                               {"L[2][1]", "1", 0.02},
                               {"L[2][2]", "1", 0.02}},
                .cause = "the accelerometer's axes have scale errors or are not square",
                .contains = {"gravity"},
                .separating_motion = "hold every face of the sensor up in turn",
                .without_attitude = true}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J.setZero();
    for (int i = 0, e = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) J(i, e++) = s.f[j];
    }
  }
};

}  // namespace

std::unique_ptr<Effect> make_acc_scale_misalignment() {
  return std::make_unique<AccScaleMisalignment>();
}

}  // namespace magimu
