// SPDX-License-Identifier: BSD-3-Clause
// acc = f averaged over the past, as mag_bandwidth has it. Of the force only gravity counts, which
// turns with the sensor: what else it averages looks like another motion of the hand.
#include "factors/effects/bandwidth.h"
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class AccBandwidth final : public Effect {
 public:
  AccBandwidth()
      : Effect({.name = "acc_bandwidth",
                .channel = Sensor::kAcc,
                .parameters = {{"v", "s^2", kUsualSpread * kUsualSpread}},
                .cause = "the accelerometer averages over some time",
                .separating_motion = "turn fast, and start and stop abruptly"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    // u'' = w x (w x u) - w' x u of what stays as it is in n.
    const Vector3 u = s.nRb.unrotate(Vector3(0.0, 0.0, 9.80665));
    J = 0.5 * (s.omega.cross(Vector3(s.omega.cross(u))) - s.omega_rate.cross(u));
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    return bandwidth_sentence("accelerometer", theta[0], sigma[0]);
  }
};

}  // namespace

std::unique_ptr<Effect> make_acc_bandwidth() { return std::make_unique<AccBandwidth>(); }

}  // namespace magimu
