// SPDX-License-Identifier: BSD-3-Clause
// mag = h(t - tau): the magnetometer shows what was tau seconds ago.
#include <fmt/format.h>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagTimeOffset final : public Effect {
 public:
  MagTimeOffset()
      : Effect({.name = "mag_time_offset",
                .channel = Sensor::kMag,
                .parameters = {{"tau", "s", 0.05}},
                .cause = "the magnetometer lags the gyroscope",
                .same_class = {"mag_lag"},
                .separating_motion = "turn fast, and start and stop abruptly"}) {}

  // b(t - tau) turns at omega x b in tau.
  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    J = s.D * s.omega.cross(s.field_before(theta[0]));
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    return s.D * (s.field_before(theta[0]) - s.b);
  }
  double delay(const VectorXd& theta) const override { return theta[0]; }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    return fmt::format("The magnetometer {} the gyroscope by {:.2f} +- {:.2f} ms.",
                       theta[0] > 0.0 ? "lags" : "is ahead of", 1e3 * std::abs(theta[0]),
                       1e3 * sigma[0]);
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_time_offset() { return std::make_unique<MagTimeOffset>(); }

}  // namespace magimu
