// SPDX-License-Identifier: BSD-3-Clause
// tau s' + s = h: the magnetometer follows the field as a filter of first order does, which
// averages the past with the weight exp(-age / tau) / tau (Gauss-Laguerre quadrature, five points:
// exact to the tenth power of tau).
#include <fmt/format.h>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr int kPoints = 5;
constexpr double kAge[kPoints] = {0.26356031971814092, 1.4134030591065168, 3.5964257710407221,
                                  7.0858100058588376, 12.640800844275783};
constexpr double kWeight[kPoints] = {0.52175561058280865, 0.39866681108317593, 0.075942449681707595,
                                     0.0036117586799220485, 2.3369972385776228e-5};

class MagLag final : public Effect {
 public:
  MagLag()
      : Effect({.name = "mag_lag",
                .channel = Sensor::kMag,
                .parameters = {{"tau", "s", 0.05}},
                .cause = "the magnetometer follows the field with a delay",
                .same_class = {"mag_time_offset"},
                .separating_motion = "turn fast, and start and stop abruptly"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    Vector3 sum = Vector3::Zero();
    for (int i = 0; i < kPoints; ++i) {
      sum += kWeight[i] * kAge[i] * s.omega.cross(s.field_before(kAge[i] * theta[0]));
    }
    J = s.D * sum;
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    Vector3 sum = Vector3::Zero();
    for (int i = 0; i < kPoints; ++i) sum += kWeight[i] * s.field_before(kAge[i] * theta[0]);
    return s.D * (sum - s.b);
  }
  double delay(const VectorXd& theta) const override { return theta[0]; }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    return fmt::format(
        "The magnetometer follows the field with a time constant of {:.2f} +- {:.2f} ms.",
        1e3 * theta[0], 1e3 * sigma[0]);
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_lag() { return std::make_unique<MagLag>(); }

}  // namespace magimu
