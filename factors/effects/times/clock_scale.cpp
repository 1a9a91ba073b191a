// SPDX-License-Identifier: BSD-3-Clause
// true dt = (1 + kappa) file dt. To the model that integrates over the file's time this is a
// gyroscope whose rates are too large or too small, S = -kappa / (1 + kappa) I: velocity and
// position of a hand-held sensor take a scale of their own that nothing else sees.
#include <fmt/format.h>

#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class ClockScale final : public Effect {
 public:
  ClockScale()
      : Effect({.name = "clock_scale",
                .channel = Sensor::kGyr,
                .parameters = {{"kappa", "1", 0.02}},
                .cause = "the file's clock runs at a wrong rate",
                .separating_motion = "turn by several full turns about each axis in turn"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    const double slow = 1.0 + theta[0];
    J = -s.omega / (slow * slow);
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    return -theta[0] / (1.0 + theta[0]) * s.omega;
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    return fmt::format(
        "The file's clock runs too {} by {:.3f} +- {:.3f} %, or all gains of the gyroscope are off "
        "alike: it reads too {} for these times.",
        theta[0] < 0.0 ? "fast" : "slowly", 100.0 * std::abs(theta[0]), 100.0 * sigma[0],
        theta[0] < 0.0 ? "much" : "little");
  }
};

}  // namespace

std::unique_ptr<Effect> make_clock_scale() { return std::make_unique<ClockScale>(); }

}  // namespace magimu
